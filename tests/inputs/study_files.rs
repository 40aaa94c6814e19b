//! Readers of what studies keep: other programs' solves, a chart's measurements, verdicts on mutants.

use crate::folder::Folder;
use crate::requirements::require_one_line;
use radiosity::studies::chart::peers::read_peers;
use radiosity::studies::chart::store::MeasurementStore;
use radiosity::studies::sabotage::store::VerdictStore;

thread_local! {
    static FOLDER: Folder = Folder::new(&[]);
}

/// Checks the readers of `peers.json`, `chart.partial.json` and `mutants.jsonl`: the input is each of them.
pub fn check_study_files(data: &[u8]) {
    FOLDER.with(|folder| {
        for name in ["peers.json", "chart.partial.json", "mutants.jsonl"] {
            folder.write(name, data);
        }
        match read_peers(&folder.path("peers.json")) {
            Ok(peers) => {
                for peer in peers {
                    let numbers = peer.time_and_error();
                    assert!(numbers.iter().all(|x| *x >= 0.0 && x.is_finite()), "{numbers:?}");
                    assert!(!peer.describe_peer().contains(char::is_control), "{peer:?}");
                }
            }
            Err(error) => require_one_line(&error),
        }
        if let Err(error) = MeasurementStore::open(folder.as_ref()) {
            require_one_line(&error);
        }
        match VerdictStore::new(folder.as_ref()).read() {
            Ok(verdicts) => assert!(verdicts.iter().all(|(key, judged)| *key == judged.key)),
            Err(error) => require_one_line(&error),
        }
    });
}
