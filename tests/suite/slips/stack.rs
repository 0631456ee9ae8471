//! Stacks of layers.

use super::{Slip, slip};

/// A tiny stack: an ink of two pigments' layers under a varnish.
pub const STACK: &str = "title = 'stack'\n\
    [stack]\nperiod_um = 0.8\n\
    [[layer]]\nname = 'varnish'\nthickness_um = 0.3\nbinder.index = 1.5\n\
    [[layer]]\nname = 'top'\nthickness_um = 0.4\nbinder.index = 1.558\n\
    [[layer.pigment]]\nname = 'yellow'\ndiameter_nm = 200\nvolume_fraction = 0.2\nindex = { n = 1.4, k = 0.1 }\n\
    [[layer]]\nname = 'bottom'\nthickness_um = 0.5\nbinder.index = 1.6\n\
    [[layer.pigment]]\nname = 'white'\ndiameter_nm = 220\nvolume_fraction = 0.1\nindex = 2.0\n\
    [light]\nwavelengths_nm = [450, 550]\n[angles]\npolar_deg = [0]\n[run]\nrealisations = 2\nseed = 7\n";

pub const OF_STACKS: &[Slip] = &[
    slip(
        "binder.index = 1.5\n",
        "binder.index = 1.5\njoint = 'open'\n",
        ["layer[0].joint", "\"open\" between binders 1.5 and 1.558", "one binder", "joint = \"wall\""],
    ),
    slip(
        "binder.index = 1.6\n",
        "binder.index = 1.6\njoint = 'wall'\n",
        ["layer[2].joint", "a joint", "last layer", "remove it"],
    ),
    slip(
        "binder.index = 1.558\n",
        "binder.index = 1.558\nrelief = { depth_um = 0.1 }\n",
        ["layer[1].relief", "a relief inside", "outer faces", "faces between layers are plane"],
    ),
    slip(
        "thickness_um = 0.4",
        "thickness_um = [0.4, 0.6]",
        ["layer[1].thickness_um", "a list", "one thickness", "add [stack.composed], or give one thickness"],
    ),
    slip(
        "[stack]\n",
        "[layer]\nthickness_um = 1\n[stack]\n",
        ["line 6", "[layer] beside [[layer]]", "one of the two", "double brackets"],
    ),
    slip(
        "[stack]\n",
        "[run]\nseed = 3\n[stack]\n",
        ["duplicate key", "\"run\" occurs twice", "keep one of the two", ""],
    ),
    slip(
        "thickness_um = 0.4",
        "thickness_um = 40",
        ["layer[1].thickness_um", "40.8 µm in all", "at most 30 µm", "thinner layers"],
    ),
    slip(
        "name = 'top'",
        "name = 'varnish'",
        ["layer[1].name", "\"varnish\"", "no other layer", "another name"],
    ),
    slip(
        "[light]",
        "[[pigment]]\nname = 'red'\ndiameter_nm = 100\nvolume_fraction = 0.1\nindex = 1.4\n[light]",
        ["pigment", "beside [[layer]]", "layers of a stack", "[[layer.pigment]]"],
    ),
    slip(
        "volume_fraction = 0.1",
        "volume_fraction = 10",
        ["layer[2].pigment[0].volume_fraction", "found 10", "0.64", "0.3 for 30 %"],
    ),
    slip(
        "thickness_um = 0.3",
        "thicknes_um = 0.3",
        ["layer[0].thicknes_um", "unknown key", "`thickness_um`", "did you mean thickness_um?"],
    ),
    slip(
        "period_um = 0.8",
        "period_um = -0.8",
        ["stack.period_um", "-0.8", "greater than 0", "larger cells"],
    ),
    slip(
        "[stack]",
        "[stack]\ncomposed = { joint_index = 0.5 }",
        ["stack.composed.joint_index", "found 0.5", "from 1.1 to 3", "that of the binders"],
    ),
    slip(
        "[stack]",
        "[stack]\ncomposed = { joint_index = 1.558 }",
        ["layer[0].binder.index", "found 1.5", "1.558 or more", "leave the clear layer out"],
    ),
    slip(
        "[stack]",
        "[stack]\nwithout_layer = true",
        ["stack.without_layer", "unknown key", "`without_layers`", "did you mean without_layers?"],
    ),
    slip(
        "[stack]",
        "[stack]\nwithout_layers = true",
        ["stack.without_layers", "true in a stack without paper", "stack on its paper", "leave it false"],
    ),
    slip("[stack]", "[stack]\nindex_in = 0", ["stack.index_in", "found 0", "from 0.1 to 10", "1 for air"]),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 450",
        ["layer[1].pigment[0].diameter_nm", "450 nm", "of at most", "a larger cell"],
    ),
];
