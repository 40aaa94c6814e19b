#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| input_tests::settings::check_settings(data));
