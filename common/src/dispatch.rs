//! Sizes of dispatches, numbers of workgroups, and places of item buffers that lie side by side in one texture. The
//! shaders have the same functions. `gpu` sizes its dispatches by them.

/// Returns the linear index of workgroup `group` in a dispatch of `groups`; a dispatch too large for x continues in y.
pub fn flat_index(group: [u32; 3], groups: [u32; 3]) -> u32 {
    group[1] * groups[0] + group[0]
}

/// Returns the size of a stage's dispatch, x and y of `groups`; empty unless the stage is `needed`.
pub fn count_workgroups(groups: [u32; 4], needed: bool) -> [u32; 3] {
    let size = if needed { [groups[0], groups[1]] } else { [0, 0] };
    [size[0], size[1], 1]
}

/// Returns column and row of item buffer `slot`, with `tiles` of them in a row.
pub fn tile_index(slot: u32, tiles: u32) -> [u32; 2] {
    [slot % tiles, slot / tiles]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workgroups_of_two_dimensions_are_numbered_once() {
        let groups = [5, 3, 1];
        let numbers = (0..3).flat_map(|y| (0..5).map(move |x| flat_index([x, y, 0], groups)));
        assert!(numbers.eq(0..15));
    }

    #[test]
    fn tiles_fill_row_after_row() {
        assert_eq!(
            [0, 2, 3, 7].map(|slot| tile_index(slot, 3)),
            [[0, 0], [2, 0], [0, 1], [1, 2]]
        );
    }

    #[test]
    fn stages_without_work_have_no_workgroups() {
        assert_eq!(count_workgroups([7, 2, 1, 0], true), [7, 2, 1]);
        assert_eq!(count_workgroups([7, 2, 1, 0], false), [0, 0, 1]);
    }
}
