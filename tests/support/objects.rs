//! The objects of random films: POV-Ray fragments and neutral solids, with
//! mirrors, glass, what filters and what does not, CSG and patterns.

/// Declarations that a fragment uses by name.
pub const NAMES: &str = "#declare Thing = superellipsoid { <0.4,0.4> scale 0.8 }\n\
    #declare Skin = texture { pigment { granite scale 0.5 } }\n";

/// What may be around the scene.
pub const SKIES: &[&str] = &[
    "sky_sphere { pigment { gradient y color_map { [0 rgb <0.8,0.8,1>][1 rgb <0.1,0.2,0.7>] } } }\n",
    "fog { distance 25 rgb <0.7,0.7,0.8> }\nbackground { rgb <0.7,0.7,0.8> }\n",
];

/// Opaque POV-Ray fragments.
pub const FRAGMENTS: [(&str, &str); 11] = [
    (
        "plain.inc",
        "#declare S = 0.8;\nbox { -S, S pigment { rgb <0.8,0.3,0.2> } finish { phong 0.6 } }\n",
    ),
    (
        "checker.inc",
        "#declare S = 1.1;\nsphere { 0, S pigment { checker rgb 1, rgb <0.1,0.3,0.8> scale 0.31 } }\n",
    ),
    (
        "bored.inc",
        "difference { sphere { 0, 1 } cylinder { -2*x, 2*x, 0.5 } cylinder { -2*y, 2*y, 0.4 pigment { rgb y } } pigment { rgb <0.9,0.9,0.2> } }\n",
    ),
    (
        "cloud.inc",
        "union { #local I = 0; #while (I < 9) sphere { <sin(I), cos(2*I), sin(3*I)>, 0.3 } #local I = I + 1; #end pigment { bozo scale 0.3 color_map { [0 rgb 0.2][1 rgb <1,0.7,0.4>] } } }\n",
    ),
    ("named.inc", "object { Thing texture { Skin } }\n"),
    (
        "torus.inc",
        "torus { 0.8, 0.25 pigment { gradient y color_map { [0 rgb x][1 rgb z] } scale 0.5 } normal { bumps 0.4 scale 0.1 } }\n",
    ),
    (
        "library.inc",
        "#include \"colors.inc\"\n#include \"woods.inc\"\nbox { -0.7, 0.7 texture { pigment { P_WoodGrain1A color_map { M_Wood1A } } } }\n",
    ),
    (
        "clear_cut.inc",
        "intersection { box { -0.8, 0.8 } sphere { 0, 1.05 } pigment { rgb <0.3,0.7,0.9> } finish { specular 0.6 roughness 0.02 } }\n",
    ),
    (
        "ghost.inc",
        "cone { -y, 0.9, y, 0.1 pigment { rgb <0.9,0.6,0.8> } no_shadow }\n",
    ),
    (
        "lamp.inc",
        "sphere { 0, 0.6 pigment { rgb <1,0.9,0.5> } finish { ambient 0 diffuse 0.2 emission 0.9 } }\n",
    ),
    (
        "mesh.inc",
        "mesh2 { vertex_vectors { 5, <0,1.1,0>, <1,-0.6,1>, <1,-0.6,-1>, <-1,-0.6,-1>, <-1,-0.6,1> } face_indices { 6, <0,1,2>, <0,2,3>, <0,3,4>, <0,4,1>, <1,2,3>, <1,3,4> } pigment { rgb <0.6,0.8,0.3> } }\n",
    ),
];

/// Opaque neutral solids.
pub const SOLIDS: [(&str, &str); 6] = [
    (
        "ball.ron",
        "material((colour: (0.2, 0.7, 0.3), phong: (amount: 0.5, size: 30)), sphere(radius: 1))",
    ),
    (
        "ring.ron",
        "difference(cylinder(base: (0, -0.3, 0), cap: (0, 0.3, 0), radius: 1), [cylinder(base: (0, -1, 0), cap: (0, 1, 0), radius: 0.6)])",
    ),
    (
        "hoop.ron",
        "material((colour: (0.8, 0.5, 0.1)), torus(major: 0.9, minor: 0.2))",
    ),
    (
        "hat.ron",
        "union([cone(base: (0, -0.6, 0), base_radius: 0.8, cap: (0, 0.9, 0)), material((colour: (0.1, 0.1, 0.4)), cylinder(base: (0, -0.8, 0), cap: (0, -0.6, 0), radius: 1.1))])",
    ),
    (
        "block.ron",
        "material((colour: (0.7, 0.6, 0.5), specular: (amount: 0.4, roughness: 0.05)), scale((1.2, 0.5, 0.8), rotate((0, 30, 0), box(min: (-0.7, -0.7, -0.7), max: (0.7, 0.7, 0.7)))))",
    ),
    ("wall.ron", "box(min: (-3, -1, -0.2), max: (3, 2, 0.2))"),
];

/// What mirrors or lets light through, fragments and solids.
pub const OPTICAL: [(&str, &str); 5] = [
    (
        "glass.inc",
        "sphere { 0, 0.9 pigment { rgbt <0.9,1,0.9,0.8> } finish { phong 1 } interior { ior 1.4 } }\n",
    ),
    (
        "pane.inc",
        "box { <-1.1,-0.9,-0.05>, <1.1,0.9,0.05> pigment { rgbf <0.9,0.4,0.3,0.7> } }\n",
    ),
    (
        "mirror.inc",
        "cylinder { -y, y, 0.7 pigment { rgb 0.2 } finish { reflection 0.7 } }\n",
    ),
    (
        "jewel.ron",
        "material((colour: (0.9, 0.2, 0.3), transmission: 0.7, ior: 1.5), intersection([sphere(radius: 1), box(min: (-0.7, -0.7, -0.7), max: (0.7, 0.7, 0.7))]))",
    ),
    (
        "chrome.ron",
        "material((colour: (0.5, 0.5, 0.5), diffuse: 0.2, reflection: 0.75, phong: (amount: 0.9, size: 80)), sphere(radius: 0.8))",
    ),
];

/// Grounds: they lie still, level, under everything.
pub const GROUNDS: [(&str, &str); 4] = [
    (
        "floor.ron",
        "material((colour: (0.6, 0.6, 0.5)), plane(normal: (0, 1, 0), distance: 0))",
    ),
    (
        "slab.ron",
        "material((colour: (0.7, 0.5, 0.4)), box(min: (-6, -0.5, -5), max: (6, 0, 7)))",
    ),
    (
        "mirror_floor.ron",
        "material((colour: (0.1, 0.1, 0.2), reflection: 0.5), box(min: (-6, -0.5, -5), max: (6, 0, 7)))",
    ),
    (
        "tiles.inc",
        "plane { y, 0 pigment { checker rgb <0.9,0.9,0.8>, rgb <0.3,0.3,0.4> } finish { diffuse 0.7 } }\n",
    ),
];
