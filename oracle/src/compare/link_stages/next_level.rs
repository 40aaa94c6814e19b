//! Checks the stages that follow a level's refinement: they count, subdivide, add and store.

use super::level::Level;
use super::tally::{Place, Word};
use super::twin::{LevelTwin, SPOTS, refinement, unwritten_lanes};
use super::{LinkStages, PAIR_WORDS, spot_groups};
use common::Result;
use common::constants::PATCH_SUM_LANES;
use cpu::hierarchy::level::{Refinement, prefix_sum, store_links, subdivide_nodes};
use gpu::hierarchy::link_probe::{MAX_PROBED_PAIRS, UNWRITTEN, as_words};
use gpu::link_records::{PairRecord, PairState, RequestRecord};

impl LinkStages {
    /// Checks the stages that make the next level and store the links, and returns that level.
    pub fn check_next_level(&mut self, twin: &LevelTwin, mut level: Level) -> Result<Level> {
        let tree = &twin.scene.tree.nodes;
        let mut room = MAX_PROBED_PAIRS;
        for pair in level
            .pairs
            .iter_mut()
            .filter(|pair| pair.state == PairState::Subdivide as u32)
        {
            let children = tree[pair.node as usize].children.len();
            match room.checked_sub(children) {
                Some(rest) => room = rest,
                None => pair.state = PairState::Skip as u32,
            }
        }
        let nodes: Vec<u32> = level.pairs.iter().map(|pair| pair.node).collect();
        let pairs = level.pairs.iter().zip(&level.lanes);
        let refined: Vec<Refinement> = pairs.map(|(pair, lanes)| refinement(pair, lanes)).collect();
        let offsets = prefix_sum(&nodes, &refined, tree);
        let offsets: Vec<[u32; 2]> = offsets
            .iter()
            .map(|[children, links]| [*children, level.links + links])
            .collect();
        let [children, links] = offsets[level.pairs.len()];
        let mut next = Level {
            pairs: Vec::new(),
            lanes: vec![unwritten_lanes(); children as usize],
            ranges: (level.ranges.iter())
                .map(|range| range.map(|pair| offsets[pair as usize][0]))
                .collect(),
            sums: level.sums.clone(),
            links,
            most: level.most.max(children),
            limits: level.limits,
        };
        let blocks = level
            .pairs
            .iter()
            .zip(&refined)
            .flat_map(|(pair, refined)| match refined {
                Refinement::Subdivide => vec![pair.block; tree[pair.node as usize].children.len()],
                _ => Vec::new(),
            });
        let ends = blocks.zip(subdivide_nodes(&nodes, &refined, &offsets, tree));
        next.pairs = ends.map(|(block, node)| PairRecord::new(block, node)).collect();
        if links > level.links {
            self.check_prefix_sum(&level, &next, &offsets, [0, 1])?;
        }
        // Once more with room for one pair less, which leaves the next level empty.
        for full in [false, true] {
            if full && children == 0 {
                continue;
            }
            self.check_prefix_sum(&level, &next, &offsets, [u32::from(full), 0])?;
            let totals = [links, u32::from(full), next.most, 0];
            let state: [(&str, &[u32]); 5] = [
                ("pairs", as_words(&level.pairs)),
                ("lanes", as_words(level.lanes.as_flattened())),
                ("counts", &[level.pairs.len() as u32]),
                ("offsets", offsets.as_flattened()),
                ("totals", &totals),
            ];
            self.check_subdivision(&level, &next, &state, full)?;
            if links > level.links {
                self.check_added_links(twin, &level, &mut next, &refined, &state, full)?;
                self.check_stored_links(&level, &nodes, &refined, &state, full)?;
            }
        }
        Ok(next)
    }

    /// Checks the sums with room for all pairs and links, except as many as are `missing` of each.
    fn check_prefix_sum(&mut self, level: &Level, next: &Level, offsets: &[[u32; 2]], missing: [u32; 2]) -> Result<()> {
        let children = next.pairs.len() as u32;
        let limits = RequestRecord {
            pairs: children - missing[0],
            links: next.links - missing[1],
            ..level.limits
        };
        let full = missing != [0; 2];
        let given: [(&str, &[u32]); 4] = [
            ("pairs", as_words(&level.pairs)),
            ("counts", &[level.pairs.len() as u32]),
            ("totals", &[level.links, 0, level.most]),
            ("request", as_words(std::slice::from_ref(&limits))),
        ];
        let made = [
            ("offsets", 2 * offsets.len()),
            ("totals", 3),
            ("next", 1),
            ("dispatches", 6),
        ];
        let found = self.run_stage(["prefix_sum"; 2], 1, &given, &made)?;
        let tally = &mut self.tallies.prefix_sum;
        for (k, (a, b)) in found[0].iter().zip(offsets.as_flattened()).enumerate() {
            tally.add_exact("pair", k / 2, k % 2, [*a, *b]);
        }
        let children = if full { 0 } else { children };
        let totals = [next.links, u32::from(full), level.most.max(children)];
        let pair_groups = children.div_ceil(PATCH_SUM_LANES as u32);
        let dispatches = [spot_groups(children as usize) as u32, 1, 1, pair_groups, 1, 1];
        for (n, (name, expected)) in [
            ("total", &totals[..]),
            ("the next level's pairs", &[children]),
            ("argument", &dispatches),
        ]
        .into_iter()
        .enumerate()
        {
            for (k, (a, b)) in found[1 + n].iter().zip(expected).enumerate() {
                tally.add_exact(name, k, 2 + n, [*a, *b]);
            }
        }
        Ok(())
    }

    fn check_subdivision(&mut self, level: &Level, next: &Level, state: &[(&str, &[u32])], full: bool) -> Result<()> {
        if next.pairs.is_empty() {
            return Ok(());
        }
        let groups = level.pairs.len().div_ceil(PATCH_SUM_LANES);
        let made = [("next", next.pairs.len() * PAIR_WORDS)];
        let found = self.run_stage(["subdivide_nodes"; 2], groups, state, &made)?;
        let nothing = [PairRecord::new(UNWRITTEN, UNWRITTEN)];
        for (k, words) in found[0].chunks(PAIR_WORDS).enumerate() {
            let expected = if full {
                &nothing
            } else {
                std::slice::from_ref(&next.pairs[k])
            };
            for (n, (a, b)) in words.iter().zip(as_words(expected)).enumerate() {
                (self.tallies.subdivide_nodes).add_exact("pair of the next level", k, n, [*a, *b]);
            }
        }
        Ok(())
    }

    fn check_added_links(
        &mut self,
        twin: &LevelTwin,
        level: &Level,
        next: &mut Level,
        refined: &[Refinement],
        state: &[(&str, &[u32])],
        full: bool,
    ) -> Result<()> {
        let given = [
            state,
            &[
                ("ranges", level.ranges.as_flattened()),
                ("sums", as_words(&level.sums)),
                ("request", as_words(std::slice::from_ref(&level.limits))),
            ],
        ]
        .concat();
        let made = [("sums", 4 * level.sums.len()), ("next", 2 * level.ranges.len())];
        let groups = level.sums.len().div_ceil(PATCH_SUM_LANES);
        let found = self.run_stage(["add_links", "add_irradiance"], groups, &given, &made)?;
        let tally = &mut self.tallies.add_links;
        for (block, range) in level.ranges.iter().enumerate() {
            let own = &level.sums[block * SPOTS..(block + 1) * SPOTS];
            let lane = |c: usize| -> [f32; SPOTS] { std::array::from_fn(|l| own[l][c]) };
            let (mut sums, mut edge) = ([0, 1, 2].map(lane), own[0][3]);
            let mut sizes = sums.map(|lanes| lanes.map(f32::abs));
            let mut links = 0;
            let own = range[0] as usize..range[1] as usize;
            for (pair, refined) in level.pairs[own.clone()].iter().zip(&refined[own]) {
                let Refinement::Link {
                    link,
                    crosses_shadow_edge,
                } = refined
                else {
                    continue;
                };
                let radiosity = &twin.request.radiosity[pair.node as usize];
                link.add_irradiance(radiosity, &mut sums);
                for (c, sizes) in sizes.iter_mut().enumerate() {
                    for (l, size) in sizes.iter_mut().enumerate() {
                        let slopes = [0, 1].map(|n| (link.along[n][l] * radiosity.slope[n][c]).abs());
                        *size += (link.weight[l] * radiosity.mean[c]).abs() + slopes[0] + slopes[1];
                    }
                }
                links += 1;
                edge = if *crosses_shadow_edge { 1.0 } else { edge };
            }
            for l in 0..SPOTS {
                let (k, expected) = (block * SPOTS + l, [sums[0][l], sums[1][l], sums[2][l], edge]);
                for (n, expected) in expected.into_iter().enumerate() {
                    let size = sizes.get(n).map_or(0.0, |sizes| sizes[l] * (links + 4) as f32);
                    let words = [found[0][4 * k + n], expected.to_bits()];
                    tally.add(Place::Item("spot", k), [k, n], words, Word::Float(size));
                }
                next.sums[k] = expected;
            }
            for n in 0..2 {
                let expected = if full { 0 } else { next.ranges[block][n] };
                tally.add_exact("block", block, 4 + n, [found[1][2 * block + n], expected]);
            }
        }
        Ok(())
    }

    fn check_stored_links(
        &mut self,
        level: &Level,
        nodes: &[u32],
        refined: &[Refinement],
        state: &[(&str, &[u32])],
        full: bool,
    ) -> Result<()> {
        let blocks = level.pairs.iter().zip(refined);
        let mut blocks = blocks.filter(|(_, refined)| matches!(refined, Refinement::Link { .. }));
        let before = level.links as usize;
        let (mut ends, mut links) = (vec![[UNWRITTEN; 2]; before], vec![[UNWRITTEN; 4]; before * SPOTS]);
        store_links(nodes, refined, |node, link, _| {
            let block = blocks.next().map_or(UNWRITTEN, |(pair, _)| pair.block);
            ends.push([block, node]);
            links.extend(
                (0..SPOTS).map(|l| [link.weight[l], link.along[0][l], link.along[1][l], 0.0].map(f32::to_bits)),
            );
        });
        if full {
            ends.fill([UNWRITTEN; 2]);
            links.fill([UNWRITTEN; 4]);
        }
        let made = [("ends", 2 * ends.len()), ("links", 4 * links.len())];
        let groups = spot_groups(level.pairs.len());
        let found = self.run_stage(["store_links"; 2], groups, state, &made)?;
        let tally = &mut self.tallies.store_links;
        for (k, (a, b)) in found[0].iter().zip(ends.as_flattened()).enumerate() {
            tally.add_exact("entry of ends", k / 2, k % 2, [*a, *b]);
        }
        for (k, (a, b)) in found[1].iter().zip(links.as_flattened()).enumerate() {
            tally.add(
                Place::Item("entry of links", k / 4),
                [k / 4, 2 + k % 4],
                [*a, *b],
                Word::Float(0.0),
            );
        }
        Ok(())
    }
}
