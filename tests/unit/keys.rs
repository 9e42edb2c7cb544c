//! The keys among the bytes that a terminal sends.

use super::*;

/// The keys in these pieces, and those found a while later. After that, a q must be a key again.
fn keys<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> Vec<u8> {
    let long_ago = Instant::now() - TICK;
    let (mut reader, mut keys) = (KeyReader::new(), vec![]);
    reader.last_arrival = long_ago;
    for piece in pieces {
        keys.extend(reader.keys(piece));
        assert!(piece.is_empty() || reader.last_arrival > long_ago);
        // However busy the machine is, the next piece comes in time.
        reader.last_arrival = Instant::now() + program::MINUTE;
    }
    reader.last_arrival = long_ago;
    keys.extend(reader.keys(b""));
    assert_eq!(reader.keys(b"q"), b"q");
    keys
}

#[test]
fn codes_are_followed_to_their_end_whole_or_in_pieces() {
    for (bytes, expected) in [
        (&b"qp x"[..], &b"qp x"[..]),
        // Arrow keys, keys of the keypad, function keys and a mouse.
        (b"\x1b[Aq", b"q"),
        (b"\x1bOqq", b"q"),
        (b"\x1b[1;5Aq", b"q"),
        (b"\x1b[5~\x1b[<35;40;12Mq", b"q"),
        // Alt and a key.
        (b"\x1bqp", b"p"),
        (b"\x1b q", b"q"),
        // A terminal's answers: what it is, where the cursor is, and a colour.
        (b"\x1bP>|a terminal q p\x1b\\q", b"q"),
        (b"\x1b[?62;22c\x1b[24;80Rq", b"q"),
        (b"\x1b]11;rgb:q/p/q\x07q", b"q"),
        (b"\x1b]11;rgb:q/p/q\x1b\\q", b"q"),
        (b"\x1bXq\x07\x1b^q\x07\x1b_q\x07q", b"q"),
        // An ESC begins another code, wherever it comes.
        (b"\x1b\x1b[Aq", b"q"),
        (b"\x1b[\x1bOqq", b"q"),
        // The Esc key.
        (b"\x1b", b"\x1b"),
        (b"x\x1b\x1b", b"x\x1b"),
        // Codes that do not go on.
        (b"\x1b[", b""),
        (b"\x1bO", b""),
        (b"\x1b]11;q", b""),
    ] {
        assert_eq!(keys([bytes]), expected, "{bytes:?}");
        assert_eq!(keys(bytes.chunks(1)), expected, "{bytes:?}");
        for (one, other) in (0..bytes.len()).map(|at| bytes.split_at(at)) {
            // The loop also looks where nothing has come yet.
            assert_eq!(keys([one, b"", other]), expected, "{bytes:?}");
        }
    }
}
