//! Levels of the trees, refined one after the other: the pairs of a node and a block become links, or pairs with the
//! node's children.

use crate::hierarchy::link::BlockLink;
use crate::hierarchy::tree::TreeNode;

/// The decision about a source at a block.
pub enum Refinement {
    /// The source sends nothing.
    Skip,
    /// The source's parts are refined in turn.
    Subdivide,
    /// The source is linked.
    Link {
        /// The link.
        link: Box<BlockLink>,
        /// A shadow edge crosses the block.
        crosses_shadow_edge: bool,
    },
}

/// Returns the number of children and of links that a pair becomes.
pub fn pair_counts(node: &TreeNode, refinement: &Refinement) -> [u32; 2] {
    match refinement {
        Refinement::Skip => [0, 0],
        Refinement::Subdivide => [node.children.len() as u32, 0],
        Refinement::Link { .. } => [0, 1],
    }
}

/// Returns, for each pair of `level`, the children and links of all pairs before it; last, those of all.
pub fn prefix_sum(level: &[u32], refined: &[Refinement], nodes: &[TreeNode]) -> Vec<[u32; 2]> {
    let mut before = [0, 0];
    let mut offsets = vec![before];
    for (k, refinement) in level.iter().zip(refined) {
        let [children, links] = pair_counts(&nodes[*k as usize], refinement);
        before = [before[0] + children, before[1] + links];
        offsets.push(before);
    }
    offsets
}

/// Returns the nodes of the next level; `offsets` are [`prefix_sum`]'s.
pub fn subdivide_nodes(level: &[u32], refined: &[Refinement], offsets: &[[u32; 2]], nodes: &[TreeNode]) -> Vec<u32> {
    let mut next = vec![0; offsets.last().map_or(0, |totals| totals[0]) as usize];
    for (pair, refinement) in refined.iter().enumerate() {
        if let Refinement::Subdivide = refinement {
            let children = &nodes[level[pair] as usize].children;
            for (k, child) in children.clone().enumerate() {
                next[offsets[pair][0] as usize + k] = child;
            }
        }
    }
    next
}

/// Passes the node of each link of a level to `store`, the link, and whether a shadow's edge crosses its block.
pub fn store_links(level: &[u32], refined: &[Refinement], mut store: impl FnMut(u32, &BlockLink, bool)) {
    for (node, refinement) in level.iter().zip(refined) {
        if let Refinement::Link {
            link,
            crosses_shadow_edge,
        } = refinement
        {
            store(*node, link, *crosses_shadow_edge);
        }
    }
}

/// Indices of pairs, in two parts that are processed by different stages.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorkList {
    /// Pairs at the front of the list.
    pub front: Vec<u32>,
    /// Pairs at its end.
    pub end: Vec<u32>,
}

/// Empties the lists of the four steps of refinement.
pub fn clear_work_lists(lists: &mut [WorkList; 4]) {
    for list in lists {
        list.front.clear();
        list.end.clear();
    }
}

/// Appends `pair` to the work list of the next stage, at its front or at its end.
pub fn append_work(work: &mut WorkList, pair: u32, last: bool) {
    let list = if last { &mut work.end } else { &mut work.front };
    list.push(pair);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appended_pairs_stand_in_their_part_until_lists_are_cleared() {
        let mut lists: [WorkList; 4] = Default::default();
        append_work(&mut lists[2], 7, false);
        append_work(&mut lists[2], 8, true);
        assert_eq!((&lists[2].front[..], &lists[2].end[..]), (&[7][..], &[8][..]));
        clear_work_lists(&mut lists);
        assert_eq!(lists, <[WorkList; 4]>::default());
    }
}
