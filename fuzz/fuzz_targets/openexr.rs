#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| input_tests::radiance_maps::check_openexr(data));
