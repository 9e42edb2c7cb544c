//! What the bytes of a terminal are taken for.

use super::*;

#[track_caller]
fn assert_keys(bytes: &[u8], keys: &str) {
    assert_eq!(String::from_iter(Terminal::parse_keys(bytes)), keys, "{:?}", bytes.escape_ascii());
}

#[test]
fn an_arrow_key_is_known_once_its_code_is_whole() {
    for start in ["\x1b[", "\x1bO", "\x1b[1;2", "\x1b\x1b["] {
        for (letter, arrow) in ["A", "B", "C", "D"].into_iter().zip(["↑", "↓", "→", "←"]) {
            let code = format!("x{start}{letter}");
            assert_keys((code.clone() + &code).as_bytes(), &format!("x{arrow}x{arrow}"));
            for end in 1..=code.len() {
                let part = &code.as_bytes()[..end];
                let is_cut = 1 < end && end < code.len();
                assert_eq!(Terminal::ends_in_code(part), is_cut, "{}", part.escape_ascii());
            }
        }
    }
}

#[test]
fn other_codes_and_answers_are_no_keys_and_the_next_key_is_one() {
    for code in [
        "\x1bq",
        "\x1bOP",
        "\x1b[5~",
        "\x1b[[C",
        "\x1b[<0;10;10M",
        // Answers about modes, colours and graphics, and which terminal it is.
        "\x1b[?2026;2$y",
        "\x1b]11;rgb:1111/1111/1111\x1b\\",
        "\x1b_Gi=31;OK\x1b\\",
        "\x1bP>|tmux 3.3a\x1b\\",
    ] {
        assert_keys(format!("{code}s").as_bytes(), "s");
        // Ctrl-C is a key even if the code is not whole.
        assert_keys(format!("{}\x03", &code[..code.len() - 1]).as_bytes(), "\x03");
    }
    // The Esc key, after another key, and held down. That, and Alt and a key, must not wait for more.
    assert_keys(b"x\x1b", "x\x1b");
    assert_keys(b"\x1b\x1b\x1b\x1b", "\x1b");
    assert!(!Terminal::ends_in_code(b"\x1b\x1b\x1b") && !Terminal::ends_in_code(b"\x1bx"));
    assert_keys("a\r\u{7f}↑".as_bytes(), "a\r\u{7f}â\u{86}\u{91}");
}
