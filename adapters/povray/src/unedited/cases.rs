//! Small texts, and what of them moves: a table. One letter a statement, in the
//! order of the text of each unit: `m` moves, `.` does not.

use super::*;

/// What an analysis says.
enum Says {
    /// Nothing is refused, and these statements move.
    Moves(&'static str),
    /// Frames are rendered whole, for a reason with these words.
    Whole(&'static str),
}
use Says::{Moves, Whole};

struct Case {
    what: &'static str,
    scene: &'static str,
    /// `u.inc`.
    include: &'static str,
    says: Says,
}

const fn case(what: &'static str, scene: &'static str, says: Says) -> Case {
    with(what, scene, "", says)
}

const fn with(what: &'static str, scene: &'static str, include: &'static str, says: Says) -> Case {
    Case {
        what,
        scene,
        include,
        says,
    }
}

const CASES: &[Case] = &[
    // Values.
    case(
        "the clock itself",
        "sphere{clock,1} sphere{0,1}",
        Moves("m."),
    ),
    case(
        "the frame's number",
        "#declare N=mod(frame_number,2); sphere{N,1}",
        Moves("m"),
    ),
    case(
        "a value",
        "#declare A=1; sphere{A,clock} sphere{A,1}",
        Moves("m."),
    ),
    case(
        "a value of a value",
        "#declare A=clock; #declare B=A*2; sphere{B,1}",
        Moves("m"),
    ),
    case(
        "constants of the animation",
        "sphere{clock_delta,final_clock} sphere{0,final_frame}",
        Moves(".."),
    ),
    case(
        "a name that begins like the clock",
        "#declare clock2=1; sphere{clock2,1}",
        Moves("."),
    ),
    case(
        "comments and strings",
        "// clock\n/* clock /* x */ clock */ text{ttf \"clock\" \"clock\" 1,0}",
        Moves("."),
    ),
    case(
        "the order does not count",
        "sphere{A,1} #declare A=clock;",
        Moves("m"),
    ),
    case(
        "an element",
        "#declare A=array[3]{0,0,0}; #declare A[1]=clock; sphere{A[2],1}",
        Moves("m"),
    ),
    case(
        "an index",
        "#declare A=array[3]{0,1,2}; #declare A[int(clock*2)]=9; sphere{A[2],1}",
        Moves("m"),
    ),
    case(
        "an array's contents",
        "#declare A=array[2]{0,clock} sphere{A[0],1}",
        Moves("m"),
    ),
    case(
        "a spline",
        "#declare S=spline{linear_spline 0,0*x 1,x} sphere{S(clock),1} sphere{S(.5),1}",
        Moves("m."),
    ),
    case(
        "a function",
        "#declare F=function(x){x+clock} sphere{F(1),1}",
        Moves("m"),
    ),
    case(
        "a function of the clock",
        "#declare F=function(x){x*2} sphere{F(clock),1} sphere{F(1),1}",
        Moves("m."),
    ),
    case(
        "a transformation",
        "#declare T=transform{rotate clock*y} sphere{x,1 transform T}",
        Moves("m"),
    ),
    case(
        "a string",
        "#declare S=concat(\"a\",str(clock,0,2)); text{ttf \"cyrvetic.ttf\" S 1,0}",
        Moves("m"),
    ),
    case(
        "a texture",
        "#declare T=texture{pigment{rgb clock}} sphere{0,1 texture{T}} sphere{0,1}",
        Moves("m."),
    ),
    case(
        "layers of a texture",
        "#declare T=texture{pigment{rgb 1}} texture{pigment{rgbt clock}} sphere{0,1 texture{T}}",
        Moves("m"),
    ),
    case(
        "a pigment in a function",
        "#declare P=pigment{rgb clock} #declare F=function{pigment{P}} isosurface{function{F(x,y,z).red}}",
        Moves("m"),
    ),
    case(
        "no semicolons",
        "#declare A = 1 #declare B = clock #declare C = 2 sphere{A,1} sphere{B,1} sphere{C,1}",
        Moves(".m."),
    ),
    case(
        "a value that ends at a statement",
        "#declare A=1 sphere{clock,A} sphere{A,1}",
        Moves("m."),
    ),
    case(
        "colours",
        "#declare C = rgb 1 filter clock; sphere{0,1 pigment{C}} sphere{0,1}",
        Moves("m."),
    ),
    case(
        "an object by its name alone",
        "#declare A=sphere{clock,1} #declare B=sphere{0,1} A B",
        Moves("m."),
    ),
    case(
        "an object of an array",
        "#declare A=array[2]{sphere{clock,1},sphere{0,1}} object{A[0]} A[1] sphere{0,1}",
        Moves("mm."),
    ),
    case(
        "declared in an object",
        "#declare U=union{sphere{0,1} #declare K=clock; sphere{x,1}} sphere{K,1}",
        Moves("m"),
    ),
    case(
        "removed",
        "#declare A=1; #if(clock>.5) #undef A #end #ifdef(A) sphere{0,1} #end",
        Moves("m"),
    ),
    case(
        "deprecated",
        "#declare deprecated once \"old\" A=clock; sphere{A,1}",
        Moves("m"),
    ),
    case(
        "blanks and comments behind #",
        "# /* x */\n declare A = clock; sphere{A,1}",
        Moves("m"),
    ),
    case(
        "a bound box",
        "#declare B=box{-clock,1} sphere{0,1 bounded_by{B}} sphere{0,1}",
        Moves("m."),
    ),
    case(
        "extents",
        "#declare O=sphere{clock,1} #declare M=min_extent(O); sphere{M,1}",
        Moves("m"),
    ),
    // Conditions and loops.
    case(
        "a condition",
        "#if(clock>.5) sphere{0,1} #else sphere{0,2} #end sphere{0,3}",
        Moves("mm."),
    ),
    case(
        "a value under a condition",
        "#declare A=0; #if(clock>.5) #declare A=1; #end sphere{A,1}",
        Moves("m"),
    ),
    case(
        "elseif",
        "#if(0) sphere{0,1} #elseif(clock) sphere{0,2} #end",
        Moves("mm"),
    ),
    case(
        "a condition in an object",
        "union{sphere{0,1} #if(clock>.5) sphere{x,1} #end} sphere{0,1}",
        Moves("m."),
    ),
    case(
        "switch",
        "#switch(int(clock*3)) #case(0) #declare A=1; #break #else #declare A=2; #end sphere{A,1}",
        Moves("m"),
    ),
    case(
        "range",
        "#switch(1) #range(0,clock) #declare A=1; #break #else #declare A=2; #end sphere{A,1}",
        Moves("m"),
    ),
    case(
        "for",
        "#for(I,0,int(5*clock)) sphere{I,.1} #end sphere{0,1}",
        Moves("m."),
    ),
    case(
        "for over constants",
        "#for(I,0,5) sphere{I,.1} #end",
        Moves("."),
    ),
    case(
        "a counter behind its loop",
        "#declare I=0; #while(I<5*clock) #declare I=I+1; #end sphere{I,1}",
        Moves("m"),
    ),
    case(
        "break",
        "#declare I=0; #while(I<9) #if(I>clock*9) #break #end #declare I=I+1; #end sphere{I,1}",
        Moves("m"),
    ),
    case(
        "break in a switch",
        "#switch(1) #case(1) #if(clock) #break #end #declare A=1; #break #end #ifdef(A) sphere{0,1} #end",
        Moves("m"),
    ),
    case(
        "break out of a macro",
        "#macro M() #if(clock) #break #end sphere{0,1} #end M() sphere{0,1}",
        Moves(".m"),
    ),
    // Includes.
    with(
        "an include's locals",
        "#include \"u.inc\" sphere{Q,1}",
        "#local Z=clock*2; #declare Q=<Z,0,0>;",
        Moves("m"),
    ),
    with(
        "an include under a condition",
        "#if(clock>.5) #include \"u.inc\" #end sphere{0,1}",
        "sphere{0,1}",
        Moves(".m"),
    ),
    with(
        "an include's objects",
        "#include \"u.inc\"",
        "sphere{clock,1} sphere{0,1}",
        Moves("m."),
    ),
    with(
        "an include in an object",
        "union{#include \"u.inc\"} sphere{0,1}",
        "sphere{clock,1} sphere{0,1}",
        Moves("m."),
    ),
    with(
        "an include in a value",
        "#declare U=union{#include \"u.inc\"} object{U}",
        "sphere{clock,1}",
        Moves("m"),
    ),
    with(
        "a macro of an include",
        "#include \"u.inc\" M(clock) M(0)",
        "#macro M(P) sphere{P,1} #end",
        Moves("m"),
    ),
    // Macros.
    case(
        "arguments",
        "#macro B(P,R) sphere{P,R} #end union{B(0,clock)} union{B(0,1) sphere{0,2}}",
        Moves("m."),
    ),
    case(
        "arguments of a macro in the scene",
        "#macro B(P) sphere{P,1} sphere{0,1} #end B(0) B(clock)",
        Moves("m."),
    ),
    case(
        "by reference",
        "#macro Set(P) #declare P=clock; #end #declare A=1; Set(A) sphere{A,1}",
        Moves("m"),
    ),
    case(
        "by reference, twice",
        "#macro S2(P) #declare P=clock; #end #macro Set(P) S2(P) #end #declare A=1; Set(A) sphere{A,1}",
        Moves("m"),
    ),
    case(
        "by reference, an element",
        "#macro Set(P) #declare P=clock; #end #declare A=array[2]{1,1}; Set(A[0]) sphere{A[1],1}",
        Moves("m"),
    ),
    case(
        "by reference, the other",
        "#macro Set(P,Q) #declare P=clock; #end #declare A=1; #declare B=1; Set(A,B) sphere{A,1} sphere{B,1}",
        Moves("m."),
    ),
    case(
        "by reference through a macro",
        "#macro Name() A #end #macro Set(P) #declare P=clock; #end #declare A=1; Set(Name()) sphere{A,1}",
        Moves("m"),
    ),
    case(
        "by reference, #local",
        "#macro Set(P) #local P=clock; #end #declare A=1; Set(A) sphere{A,1}",
        Moves("m"),
    ),
    case(
        "by reference from an argument",
        "#macro Copy(P,Q) #declare P=Q; #end #declare A=1; Copy(A,clock) sphere{A,1}",
        Moves("m"),
    ),
    case(
        "by reference from a callee",
        "#macro In() #declare P=clock; #end #macro Out(P) In() #end #declare A=1; Out(A) sphere{A,1}",
        Moves("m"),
    ),
    with(
        "by reference from an include",
        "#macro Out(P) #include \"u.inc\" #end #declare A=1; Out(A) sphere{A,1}",
        "#declare P=clock;",
        Moves("m"),
    ),
    case(
        "a parameter called like a value",
        "#declare P=clock; #macro M(P) sphere{P,1} #end #declare A=1; M(A) sphere{A,1}",
        Moves(".m"),
    ),
    case(
        "no commas",
        "#macro Copy(P Q) #declare P=Q; #end #declare A=1; Copy(A clock) sphere{A,1}",
        Moves("m"),
    ),
    case(
        "a comparison as an argument",
        "#macro M(P,Q) sphere{Q,1} #end #declare A=1; M(A<2, clock>3)",
        Moves("m"),
    ),
    case(
        "scoping is dynamic",
        "#declare V=0; #macro In() V #end #macro Out(X) #local V=X; sphere{In(),1} #end Out(clock)",
        Moves("m"),
    ),
    case(
        "a local hides a name",
        "#declare V=clock; #macro M() #local V=1; sphere{V,1} #end M()",
        Moves("m"),
    ),
    case(
        "a local of one call",
        "#macro M(X) #local V=X; sphere{V,1} #end union{M(clock)} union{M(1)}",
        Moves("m."),
    ),
    case(
        "a local that is not always made",
        "#macro M(X) #if(X) #local V=X; #end sphere{V,1} #end #declare V=0; union{M(clock)} union{M(1)}",
        Moves("mm"),
    ),
    case(
        "a value from a macro",
        "#macro M(X) #declare G=X; #end M(clock) sphere{G,1}",
        Moves("m"),
    ),
    case(
        "a macro's value",
        "#macro M(X) (X*2) #end sphere{M(clock),1} sphere{M(1),1}",
        Moves("m."),
    ),
    case(
        "a macro with the clock",
        "#macro M(X) (X*clock) #end sphere{M(1),1}",
        Moves("m"),
    ),
    case(
        "a macro under a condition",
        "#macro Bump() #declare G=G+1; #end #declare G=0; #if(clock>.5) Bump() #end sphere{G,1}",
        Moves("m"),
    ),
    case(
        "a macro twice",
        "#macro M() 1 #end #if(clock>.5) #macro M() 2 #end #end sphere{M(),1}",
        Moves("m"),
    ),
    case(
        "a macro that nobody calls",
        "#macro M() #declare A=clock; #end #declare A=1; sphere{A,1}",
        Moves("."),
    ),
    case(
        "a condition on an argument",
        "#macro M(X) #if(X>0) #declare G=1; #end #end #declare G=0; M(clock) sphere{G,1}",
        Moves("m"),
    ),
    case(
        "a removed parameter",
        "#macro M(X) #undef X sphere{X,1} #end #declare X=0; M(clock)",
        Moves("m"),
    ),
    case(
        "a loop in a macro",
        "#macro M(N) #local I=0; #while(I<N) sphere{I,1} #local I=I+1; #end #end union{M(3)} union{M(clock)}",
        Moves(".m"),
    ),
    case(
        "recursion",
        "#macro M(N,P) #if(N>0) sphere{P,1} M(N-1,P+x) #end #end union{M(3,0)} union{M(2,clock)}",
        Moves(".m"),
    ),
    // Streams and tracing.
    case(
        "a stream",
        "#declare S=seed(1); #declare I=0; #while(I<5*clock) #declare Q=rand(S); #declare I=I+1; #end sphere{rand(S),1}",
        Moves("m"),
    ),
    case(
        "a stream with two names",
        "#declare S=seed(1); #declare S2=S; #if(clock>.5) #declare Q=rand(S); #end sphere{rand(S2),1}",
        Moves("m"),
    ),
    case(
        "one stream or another",
        "#declare S=seed(1); #declare R=seed(2); #declare Q=rand((clock<.5?S:R)); sphere{rand(S),1}",
        Moves("m"),
    ),
    case(
        "a stream of its own",
        "#declare S=seed(1); sphere{rand(S),1} sphere{clock,1}",
        Moves(".m"),
    ),
    case(
        "a stream more or less",
        "#if(clock>.5) #declare D=seed(7); #end sphere{rand(0),1}",
        Moves("m"),
    ),
    case(
        "a stream in an object that moves",
        "#declare S=seed(1); union{sphere{clock,rand(S)}} sphere{rand(S),1}",
        Moves("m."),
    ),
    case(
        "trace",
        "#declare O=sphere{clock,1} #declare N=<0,0,0>; #declare P=trace(O,-9*z,z,N); sphere{N,1} sphere{P,1}",
        Moves("mm"),
    ),
    case(
        "trace what is still",
        "#declare O=sphere{0,1} #declare N=<0,0,0>; #declare P=trace(O,-9*z,z,N); sphere{N,1}",
        Moves("."),
    ),
    case(
        "trace in a macro",
        "#macro T(O,M) #declare P=trace(O,-9*z,z,M); #end #declare N=0*x; T(sphere{clock,1},N) sphere{N,1}",
        Moves("m"),
    ),
    // What is rendered whole.
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
        "sphere{0,1 hollow interior{media{scattering{1 1}}}}",
        Whole("media"),
    ),
    case(
        "a lens",
        "camera{location x look_at 0 aperture .1 blur_samples 9 focal_point 0}",
        Whole("a lens"),
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

fn analysed(case: &Case) -> (Sources, Analysis) {
    let scene = format!("#version 3.7;\n{}\n", case.scene);
    let sources = Sources::of_texts(&[("a.pov", &scene), ("u.inc", case.include)]);
    let analysis = analyse(&sources, &Options::default());
    (sources, analysis)
}

fn letters(analysis: &Analysis) -> String {
    let objects = analysis
        .statements
        .iter()
        .filter(|s| matches!(s.kind, Kind::Object(_)));
    objects.map(|s| if s.moves { 'm' } else { '.' }).collect()
}

#[test]
fn what_moves_and_what_is_refused() {
    let mut wrong = Vec::new();
    for case in CASES {
        let (_, analysis) = analysed(case);
        let whole: Vec<String> = analysis.whole.iter().map(ToString::to_string).collect();
        let found = letters(&analysis);
        let right = match case.says {
            Moves(expected) => whole.is_empty() && found == expected,
            Whole(reason) => whole.iter().any(|refusal| refusal.contains(reason)),
        };
        if !right {
            wrong.push(format!("{}: {found:?}, refused: {whole:?}", case.what));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        CASES.len(),
        wrong.join("\n")
    );
}

#[test]
fn reasons_are_told_with_their_places() {
    let scene = "#declare V = clock*2;\n#declare P =\n  V*x;\nsphere { P, 1 }\n";
    let sources = Sources::of_texts(&[("a.pov", scene)]);
    let analysis = analyse(&sources, &Options::default());
    let (_, statement) = analysis.moving().next().expect("it moves");
    assert_eq!(statement.line, 4);
    assert_eq!(&scene[statement.range.clone()], "sphere { P, 1 }");
    assert_eq!(
        statement.why,
        "it is made with `P` (a.pov:2, with `V` (a.pov:1, with `clock`))"
    );
}

#[test]
fn mirrors_and_glass_are_known() {
    let scene = "#declare F=finish{reflection .3} #macro G(N) interior{ior N} #end \
                 sphere{0,1 finish{F}} sphere{0,1 G(1.5)} sphere{0,1} \
                 #while(0) sphere{0,1} #end";
    let sources = Sources::of_texts(&[("a.pov", scene)]);
    let analysis = analyse(&sources, &Options::default());
    let bends: Vec<bool> = analysis.statements.iter().map(|s| s.bends).collect();
    assert_eq!(bends, [true, true, false, false]);
    assert!(analysis.statements[3].repeated && !analysis.statements[2].repeated);
    let sources = Sources::of_texts(&[("a.pov", "#default{finish{reflection 1}} sphere{0,1}")]);
    assert!(analyse(&sources, &Options::default()).statements[0].bends);
}

#[test]
fn options_refuse() {
    let sources = Sources::of_texts(&[("a.pov", "sphere{clock,1}")]);
    let options = Options {
        refused: vec!["frames read each other".into()],
    };
    let analysis = analyse(&sources, &options);
    assert_eq!(analysis.whole[0].to_string(), "frames read each other");
}

#[test]
fn added_names_are_nobodys() {
    let scene = "#declare decor0_F=1; sphere{clock,1} // decor1_";
    let sources = Sources::of_texts(&[("a.pov", scene)]);
    assert_eq!(sources.prefix, "decor2_");
}
