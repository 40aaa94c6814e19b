#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| input_tests::baked_scenes::check_baked_scene(data));
