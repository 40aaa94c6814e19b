#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| input_tests::scene_files::check_glb(data));
