//! Groups the cases by task, a solve or a relight, since their methods differ.

use super::CaseStudy;
use super::methods;
use super::trial::MethodSuite;

/// Cases with the same methods.
pub struct CaseGroup<'a> {
    /// Name of the task.
    pub name: &'static str,
    /// Studies with their index in the atlas.
    pub studies: Vec<(usize, &'a CaseStudy)>,
    /// Methods in order of appearance, which determines their colours.
    pub methods: Vec<&'static str>,
}

/// Returns the groups that are not empty.
pub fn group_cases(studies: &[CaseStudy]) -> Vec<CaseGroup<'_>> {
    let group = |(name, relights): (&'static str, bool)| {
        let numbered = studies.iter().enumerate();
        let members: Vec<_> = numbered.filter(|(_, s)| is_relight(s) == relights).collect();
        CaseGroup {
            name,
            methods: method_names(members.iter().map(|(_, study)| *study)),
            studies: members,
        }
    };
    let all = [("Solved", false), ("Relit", true)].into_iter().map(group);
    all.filter(|group| !group.studies.is_empty()).collect()
}

/// Returns the names of the methods in order of appearance.
pub fn method_names<'a>(studies: impl IntoIterator<Item = &'a CaseStudy>) -> Vec<&'static str> {
    let mut names = Vec::new();
    for row in studies.into_iter().flat_map(|study| &study.rows) {
        if !names.contains(&row.method) {
            names.push(row.method);
        }
    }
    names
}

/// Returns whether any method of the study is for relighting only.
fn is_relight(study: &CaseStudy) -> bool {
    let [solves, relights] = [MethodSuite::All, MethodSuite::Relight(0)].map(methods::methods_of);
    let only = |name: &str| relights.iter().any(|m| m.name == name) && solves.iter().all(|m| m.name != name);
    study.rows.iter().any(|row| only(row.method))
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side, make_study};
    use super::*;

    #[test]
    fn relights_have_their_own_group() {
        let one = |method: &'static str| {
            let mut one = make_row(1.0, make_side(Some(0.01), ""), None);
            one.method = method;
            one
        };
        let studies = [
            make_study("a", vec![one("default"), one("paper")]),
            make_study("b", vec![one("default"), one("signed"), one("paper")]),
            make_study("c", vec![one("matrix")]),
        ];
        let found = group_cases(&studies);
        let places = |k: usize| found[k].studies.iter().map(|(n, _)| *n).collect::<Vec<_>>();
        assert_eq!((found.len(), places(0), places(1)), (2, vec![0, 2], vec![1]));
        assert_eq!(found[0].methods, ["default", "paper", "matrix"]);
    }
}
