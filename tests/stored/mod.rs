//! Files of the source tree that are made by the program or from its options, such as pictures and
//! completions. They are checked in, so that they can be read and packaged without a build. The tests
//! regenerate all but the table of measurements, and fail if one is stale.

use std::{env, fs};

/// The full path of a file of the source tree.
pub fn path(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))
}

pub fn read(name: &str) -> String {
    fs::read_to_string(path(name)).unwrap()
}

/// Checks that a file has these contents. With `UPDATE=1` in the environment, writes them first.
#[track_caller]
pub fn assert_current(name: &str, contents: &str) {
    if env::var_os("UPDATE").is_some() {
        fs::write(path(name), contents).unwrap();
    }
    assert!(read(name) == contents, "{name} is stale: run UPDATE=1 cargo test, and commit it");
}
