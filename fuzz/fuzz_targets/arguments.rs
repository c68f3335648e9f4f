//! Fuzzes `readers::words::arguments`.
#![no_main]

mod common;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| common::read(common::readers::words::arguments, bytes));
