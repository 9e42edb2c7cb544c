//! The shape of a character cell, as the terminal tells it.

use super::*;

#[test]
fn the_aspect_of_a_cell_comes_from_the_windows_pixels_if_they_can_be_right() {
    for (cells, pixels, aspect) in [
        // xterm, with and without a border of 20 pixels, and at the end of --aspect's range.
        ((120, 36), (720, 468), 13.0 / 6.0),
        ((120, 36), (1240, 760), 21.0 / 10.0),
        ((80, 24), (719, 407), 2.0),
        ((80, 24), (720, 408), 17.0 / 9.0),
        ((80, 24), (800, 24), 0.1),
        ((80, 24), (80, 240), 10.0),
        // Neither of the two is told, or only one, as by telnet.
        ((80, 24), (0, 0), 2.0),
        ((80, 24), (0, 408), 2.0),
        ((80, 24), (32_000, 0), 2.0),
        // Less than a pixel for each cell, or a shape that no font has.
        ((80, 24), (79, 408), 2.0),
        ((80, 24), (720, 23), 2.0),
        ((80, 24), (880, 24), 2.0),
        ((80, 24), (80, 264), 2.0),
        // What OpenSSH for Windows says of every window, and almost the same.
        ((120, 36), (640, 480), 2.0),
        ((120, 36), (640, 504), 14.0 / 5.0),
        ((u16::MAX, u16::MAX), (u16::MAX, u16::MAX), 1.0),
    ] {
        assert_eq!(cell_aspect(cells, pixels), aspect, "{cells:?} in {pixels:?}");
    }
}
