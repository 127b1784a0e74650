//! What is rendered whole.

use super::Says::{Moves, Whole};
use super::{Case, case, with};

pub(super) const CASES: &[Case] = &[
    case(
        "the camera",
        "camera{location clock*x look_at 0} sphere{0,1}",
        Whole("the camera moves: it is made with `clock`"),
    ),
    case(
        "the camera under a condition",
        "#if(clock) camera{location x} #end sphere{0,1}",
        Whole("the camera moves: whether"),
    ),
    case(
        "a light",
        "light_source{clock*x 1} sphere{0,1}",
        Whole("a light changes"),
    ),
    case(
        "the sky",
        "sky_sphere{pigment{rgb clock}} sphere{0,1}",
        Whole("`sky_sphere` changes"),
    ),
    case(
        "fog",
        "fog{distance clock rgb 1} sphere{0,1}",
        Whole("`fog` changes"),
    ),
    case(
        "the background",
        "background{rgb clock} sphere{0,1}",
        Whole("`background` changes"),
    ),
    case(
        "settings",
        "global_settings{ambient_light clock} sphere{0,1}",
        Whole("`global_settings` changes"),
    ),
    case(
        "#default",
        "#default{pigment{rgb clock}} sphere{0,1}",
        Whole("#default changes"),
    ),
    case(
        "default without #",
        "default{pigment{rgb clock}} sphere{0,1}",
        Whole("#default changes"),
    ),
    case(
        "default without #, still",
        "default{pigment{rgb 1}} sphere{clock,1}",
        Moves("m"),
    ),
    case(
        "brackets of a macro that nobody calls",
        "#macro M() ( #if(1) } #end #end sphere{clock,1} sphere{0,1}",
        Moves("m."),
    ),
    case(
        "#default in an object",
        "union{#default{pigment{rgb clock}} sphere{0,1}}",
        Whole("#default changes"),
    ),
    case(
        "#version",
        "#if(clock) #version 3.5; #end sphere{0,1}",
        Whole("#version changes"),
    ),
    case(
        "a plane",
        "plane{y,clock}",
        Whole("an object without end moves"),
    ),
    case(
        "a light in what moves",
        "union{light_source{0 1} sphere{clock,1}}",
        Whole("a light is a part of what moves"),
    ),
    case(
        "a light by name in what moves",
        "#declare L=light_source{0 1} union{object{L} sphere{clock,1}}",
        Whole("a light is a part of what moves"),
    ),
    case(
        "radiosity",
        "global_settings{radiosity{count 9}} sphere{clock,1}",
        Whole("radiosity"),
    ),
    case(
        "photons",
        "global_settings{photons{count 9}} sphere{clock,1}",
        Whole("photons"),
    ),
    case(
        "objects without photons",
        "sphere{0,1 photons{target}} sphere{clock,1}",
        Moves(".m"),
    ),
    case(
        "subsurface",
        "sphere{0,1 finish{subsurface{translucency 1}}} sphere{clock,1}",
        Whole("subsurface"),
    ),
    case(
        "crand",
        "#declare F=finish{crand .1} sphere{0,1 finish{F}} sphere{clock,1}",
        Whole("crand"),
    ),
    case(
        "crand that nobody uses",
        "#declare F=finish{crand .1} sphere{0,1} sphere{clock,1}",
        Moves(".m"),
    ),
    case(
        "media",
        "sphere{0,1 hollow interior{media{scattering{1 1}}}} sphere{clock,1}",
        Moves(".m"),
    ),
    case(
        "a lens",
        "camera{location x look_at 0 aperture .1 blur_samples 9 focal_point 0} sphere{clock,1}",
        Moves("m"),
    ),
    case(
        "a light that jitters",
        "light_source{y 1 area_light x,z,3,3 jitter} sphere{clock,1}",
        Whole("jitters"),
    ),
    case(
        "a light of some size",
        "light_source{y 1 area_light x,z,3,3 adaptive 1} sphere{clock,1}",
        Moves("m"),
    ),
    case(
        "#read",
        "#fopen F \"a.txt\" read #read(F,A) sphere{A,1}",
        Whole("it reads or writes a file"),
    ),
    case(
        "#write",
        "#fopen F \"a.txt\" write #write(F,clock) sphere{0,1}",
        Whole("it reads or writes a file"),
    ),
    case(
        "a file that a macro would write",
        "#macro W() #fopen F \"a.txt\" write #end sphere{clock,1}",
        Moves("m"),
    ),
    case(
        "the time",
        "sphere{now,1}",
        Whole("it asks for the time (`now`)"),
    ),
    case(
        "the scene's name",
        "text{ttf \"a.ttf\" input_file_name 1,0}",
        Whole("its own name"),
    ),
    case(
        "a computed include",
        "#include concat(\"u\",\".inc\")",
        Whole("the name of the file is computed"),
    ),
    case(
        "an include that is not there",
        "#include \"v.inc\" sphere{0,1}",
        Whole("`v.inc` was not found"),
    ),
    case(
        "the scene includes itself",
        "#if(clock>2) #include \"a.pov\" #end sphere{0,1}",
        Whole("the scene includes itself"),
    ),
    case("an inverse object", "sphere{clock,1 inverse}", Moves("m")),
    case(
        "an inverse object in fog",
        "fog{distance 9 rgb 1} sphere{clock,1 inverse}",
        Whole("(inverse)"),
    ),
    case(
        "an inverse object of glass",
        "sphere{clock,1 inverse interior{ior 2}}",
        Whole("(inverse)"),
    ),
    case(
        "braces in branches",
        "#if(clock) union{ #else merge{ #end sphere{0,1} }",
        Whole("has no partner"),
    ),
    case(
        "a brace in a branch",
        "#if(clock) union{ #end sphere{0,1} #if(clock) } #end",
        Whole("different branches"),
    ),
    case(
        "a macro that opens a brace",
        "#macro Begin() union{ #end #macro End() } #end Begin() sphere{0,1} End()",
        Whole("has no partner"),
    ),
    case(
        "a keyword by a macro",
        "#macro Kind() sphere #end Kind() {clock,1}",
        Whole("decor does not understand this"),
    ),
    case("no end", "#if(clock) sphere{0,1}", Whole("has no #end")),
    case("an end too many", "sphere{0,1} #end", Whole("ends nothing")),
    case(
        "break in a brace",
        "#while(1) union{sphere{0,1} #break} #end",
        Whole("leaves braces"),
    ),
    case(
        "a directive in an expression",
        "#declare A = 1 + #if(clock) 2 #else 3 #end; sphere{A,1}",
        Whole("not certain"),
    ),
    case(
        "a directive as a value",
        "#declare A = #if(clock) 2 #else 3 #end; sphere{A,1}",
        Whole("not certain"),
    ),
    case(
        "a directive within brackets",
        "#declare A = (1 + #if(clock) 2 #else 3 #end); sphere{A,1}",
        Moves("m"),
    ),
    case(
        "a macro that may make nothing",
        "#macro M(X) #if(X) 1 #end #end #declare A = M(1) #declare B = clock; sphere{A,1}",
        Whole("not certain"),
    ),
    case(
        "a macro that makes something",
        "#macro M(X) sphere{0,X} #end #declare A = M(1) #declare B = clock; object{A} sphere{B,1}",
        Moves(".m"),
    ),
    case(
        "a directive of 3.8",
        "#frobnicate sphere{0,1}",
        Whole("does not know this directive"),
    ),
    case(
        "a comment without end",
        "sphere{0,1} /* clock",
        Whole("no end"),
    ),
    case(
        "a number and a word",
        "sphere{<2clock,0,0>,1}",
        Whole("runs into"),
    ),
    case("no ASCII", "sphere{0,1} \u{e9}", Whole("none of POV-Ray's")),
    case(
        "#declare without #",
        "declare A=clock; sphere{A,1}",
        Whole("decor does not understand this"),
    ),
    case(
        "3.8's tuples",
        "#declare (A,B)=(clock,1); sphere{A,1}",
        Whole("has no name"),
    ),
    case(
        "#include without #",
        "include \"u.inc\" sphere{A,1}",
        Whole("decor does not understand this"),
    ),
    case(
        "a macro for a value, with objects",
        "#macro M() sphere{0,1} #end M() #if(vlength(min_extent(M()))) sphere{clock,1} #end",
        Whole("called for a value"),
    ),
    with(
        "a file in both places",
        "#include \"u.inc\" union{#include \"u.inc\"}",
        "sphere{clock,1}",
        Whole("in one place and parts"),
    ),
];
