//! Fuzzes `readers::files::table`.
#![no_main]

mod common;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| common::read(common::readers::files::table, bytes));
