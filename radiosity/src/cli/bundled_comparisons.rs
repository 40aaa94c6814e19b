//! Comparisons of bundled scenes that together run every shader: each visibility, projection and lookup, one sample and
//! several, form factors, links between nodes, relighting. `compare --all` shows them, and `sabotage` judges mutants by them.

/// Returns the scene and the options of each, the cheapest first.
pub fn bundled_comparisons() -> Vec<String> {
    COMPARE_ARGUMENTS.map(str::to_owned).to_vec()
}

const COMPARE_ARGUMENTS: [&str; 11] = [
    "occluded_plates.obj --texels 5 --patches 1 --samples 3 --visibility rays --lamp 0.1,0.7,0.2,0.5",
    "occluded_plates.obj --texels 4 --patches 1 --samples 1 --form-factor disc --iteration southwell --item-buffer 64",
    "occluded_plates.obj --texels 4 --error 5% --lamp 0.1,0.7,0.2,0.5",
    "occluded_plates.obj --texels 4 --patches 1 --samples 1 --form-factor paper --iteration southwell \
     --visibility paper --item-buffer 64",
    "occluded_plates.obj --texels 5 --patches 2 --samples 4 --visibility hemicube --item-buffer 64",
    "occluded_plates.obj --texels 4 --patches 2 --samples 2 --visibility hemisphere --item-buffer 64 --conserve --two-sided",
    "slivers.obj --texels 12 --patches 1 --samples 2 --visibility rays",
    "paper_room_objects.obj --texels 2 --patches 1 --samples 2 --visibility rays",
    "cornell_box.obj --texels 5 --patches 5 --samples 2 --visibility rays",
    "cornell_box.obj --texels 2 --error 10%",
    "slivers.obj --texels 4 --error 5%",
];
