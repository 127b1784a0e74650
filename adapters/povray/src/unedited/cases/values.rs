//! Values, conditions, loops, includes.

use super::Says::Moves;
use super::{Case, case, with};

pub(super) const CASES: &[Case] = &[
    // Values.
    case(
        "one of two objects, by the clock",
        "#declare A = #if(clock) sphere{0,1} #else box{0,1} #end object{A} sphere{0,1}",
        Moves("m."),
    ),
    case(
        "one of two objects, whatever the clock says",
        "#declare A = #ifdef(B) sphere{0,1} #else box{0,1} #end object{A} sphere{clock,1}",
        Moves(".m"),
    ),
    case(
        "one of two objects, of which one moves",
        "#declare A = #ifdef(B) sphere{clock,1} #else box{0,1} #end object{A} sphere{0,1}",
        Moves("m."),
    ),
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
];
