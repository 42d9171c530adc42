//! Standard output. Whoever reads it may stop when they have seen enough (`crumple list | head`), which is no error.

use std::io::{ErrorKind, Write, stdout};

/// Writes text. Where that fails the program ends, but for a reader who is gone: then it goes on in silence.
pub fn say(text: std::fmt::Arguments) {
    if let Err(error) = stdout().write_fmt(text)
        && error.kind() != ErrorKind::BrokenPipe
    {
        eprintln!("error: can't write to standard output: {error}");
        std::process::exit(2);
    }
}

/// Writes text as `print!` does.
macro_rules! say {
    ($($text:tt)*) => { $crate::cli::say::say(format_args!($($text)*)) };
}

/// Writes a line as `println!` does.
macro_rules! say_line {
    () => { say!("\n") };
    ($($text:tt)*) => { say!("{}\n", format_args!($($text)*)) };
}
