//! The cases by what they ask: a solve, or an object put into a room. The methods differ.

use super::Study;
use super::methods;
use super::trial::Suite;

/// Cases whose methods are alike.
pub struct Group<'a> {
    /// What is asked of them.
    pub name: &'static str,
    /// Their places in the atlas, and they.
    pub studies: Vec<(usize, &'a Study)>,
    /// Their methods, in the order in which they come: it decides the colours.
    pub methods: Vec<&'static str>,
}

/// All that are not empty.
pub fn groups(studies: &[Study]) -> Vec<Group<'_>> {
    let of = |(name, relights): (&'static str, bool)| {
        let numbered = studies.iter().enumerate();
        let own: Vec<_> = numbered.filter(|(_, s)| relit(s) == relights).collect();
        Group {
            name,
            methods: names(own.iter().map(|(_, study)| *study)),
            studies: own,
        }
    };
    let all = [("Solved", false), ("Relit", true)].into_iter().map(of);
    all.filter(|group| !group.studies.is_empty()).collect()
}

/// The methods, in the order in which they come.
pub fn names<'a>(studies: impl IntoIterator<Item = &'a Study>) -> Vec<&'static str> {
    let mut names = Vec::new();
    for row in studies.into_iter().flat_map(|study| &study.rows) {
        if !names.contains(&row.method) {
            names.push(row.method);
        }
    }
    names
}

/// Whether some method is one that only relights.
fn relit(study: &Study) -> bool {
    let [solves, relights] = [Suite::All, Suite::Relight(0)].map(methods::of);
    let only = |name: &str| {
        relights.iter().any(|m| m.name == name) && solves.iter().all(|m| m.name != name)
    };
    study.rows.iter().any(|row| only(row.method))
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side, study};
    use super::*;

    #[test]
    fn relights_have_their_own_group() {
        let one = |method: &'static str| {
            let mut one = row(1.0, side(Some(0.01), ""), None);
            one.method = method;
            one
        };
        let studies = [
            study("a", vec![one("default"), one("paper")]),
            study("b", vec![one("default"), one("signed"), one("paper")]),
            study("c", vec![one("matrix")]),
        ];
        let found = groups(&studies);
        let places = |k: usize| found[k].studies.iter().map(|(n, _)| *n).collect::<Vec<_>>();
        assert_eq!(
            (found.len(), places(0), places(1)),
            (2, vec![0, 2], vec![1])
        );
        assert_eq!(found[0].methods, ["default", "paper", "matrix"]);
    }
}
