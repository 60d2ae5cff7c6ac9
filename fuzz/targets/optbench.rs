#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fstop_fuzz::run("optbench", bytes));
