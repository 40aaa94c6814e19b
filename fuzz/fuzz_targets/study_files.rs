#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| input_tests::study_files::check_study_files(data));
