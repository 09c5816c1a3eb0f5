//! Integration tests, by promise. One binary, so that it is linked once.

#[cfg(feature = "cli")]
mod cli;
