//! Macros and their parameters, streams of random numbers, `trace`.

use super::Says::Moves;
use super::{Case, case, with};

pub(super) const CASES: &[Case] = &[
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
];
