"""The languages: one table of how each writes numbers, operations and statements."""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from remanent.codegen.languages.language import Language

#: Functions of one value, under the names of the instructions.
_FUNCTIONS: Final = ("sqrt", "exp", "log", "sin", "cos", "atan", "floor")
#: Arithmetic, which all of these languages write alike.
_ARITHMETIC: Final = {
    "add": "{} + {}",
    "sub": "{} - {}",
    "mul": "{}*{}",
    "div": "{}/{}",
    "neg": "-{}",
}


def _operations(call: str = "{}", **others: str) -> dict[str, str]:
    """Arithmetic, and functions with `call` around their names, or with `others` as names."""
    names = {name: others.get(name, call.format(name)) for name in _FUNCTIONS}
    return {**_ARITHMETIC, **{name: f"{text}({{}})" for name, text in names.items()}}


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


#: Names of functions and variables of the files themselves.
_OWN_WORDS: Final = _words("""
    t y p row dydt k rates load parameters initial state_names breaks pieces piece_starts low high
    middle duration period options ends span
""")

_PYTHON = Language(
    operations=_operations("np.{}", atan="np.arctan"),
    assignment="{} = {}",
    comment="#",
    reserved_words=_OWN_WORDS
    | frozenset((*keyword.kwlist, *keyword.softkwlist))
    | _words("np bisect_right max"),
    not_a_number="np.nan",
    infinity="np.inf",
)

_C = Language(
    operations=_operations(),
    assignment="const double {} = {};",
    comment="//",
    reserved_words=_OWN_WORDS
    | frozenset(_FUNCTIONS)
    | _words("""
    alignas alignof and and_eq asm atomic_cancel auto bitand bitor bool break case catch char
    char8_t class compl concept const const_cast consteval constexpr constinit continue co_await
    co_return co_yield decltype default delete do double dynamic_cast else enum explicit export
    extern false float for friend fortran goto if inline int long mutable namespace new noexcept
    not not_eq nullptr operator or or_eq private protected public register reinterpret_cast
    requires restrict return short signed sizeof static static_assert static_cast struct switch
    template this thread_local throw true try typedef typeid typename typeof typeof_unqual union
    unsigned using virtual void volatile wchar_t while xor xor_eq main piece_at
    NAN INFINITY HUGE_VAL HUGE_VALF HUGE_VALL FP_INFINITE FP_NAN FP_NORMAL FP_SUBNORMAL FP_ZERO
    FP_ILOGB0 FP_ILOGBNAN FP_FAST_FMA FP_FAST_FMAF FP_FAST_FMAL MATH_ERRNO MATH_ERREXCEPT
    math_errhandling MAXFLOAT M_E M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI M_PI_2 M_PI_4 M_1_PI M_2_PI
    M_2_SQRTPI M_SQRT2 M_SQRT1_2 DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS linux unix i386
    REMANENT_STATES
    """),
    not_a_number="NAN",
    infinity="INFINITY",
)

_JAVASCRIPT = Language(
    operations=_operations("Math.{}"),
    assignment="const {} = {};",
    comment="//",
    reserved_words=_OWN_WORDS
    | _words("""
    arguments async await break case catch class const continue debugger default delete do else
    enum eval export extends false finally for from function get if implements import in
    instanceof interface let new null of package private protected public return set static super
    switch this throw true try typeof undefined var void while with yield Math NaN Infinity
    pieceAt
    """),
)

_JULIA = Language(
    operations=_operations(sqrt="real_sqrt", log="real_log", sin="real_sin", cos="real_cos"),
    assignment="{} = {}",
    comment="#",
    reserved_words=_OWN_WORDS
    | frozenset(_FUNCTIONS)
    | _words("""
    abstract baremodule begin break catch const continue do else elseif end export false finally
    for function global if import in isa let local macro module mutable outer primitive public
    quote return struct true try type using where while NaN Inf nothing missing im pi Base Core
    Main max isfinite searchsortedlast real_sqrt real_log real_sin real_cos Float64 solve problem
    """),
    # Outside their range these four raise errors in Julia, and nothing can go on.
    helpers=MappingProxyType(
        {
            "sqrt": "real_sqrt(x) = x < 0 ? NaN : sqrt(x)",
            "log": "real_log(x) = x < 0 ? NaN : log(x)",
            "sin": "real_sin(x) = isfinite(x) ? sin(x) : NaN",
            "cos": "real_cos(x) = isfinite(x) ? cos(x) : NaN",
        }
    ),
    infinity="Inf",
)

_MATLAB = Language(
    operations=_operations(sqrt="real_sqrt", log="real_log"),
    assignment="{} = {};",
    comment="%",
    reserved_words=_OWN_WORDS
    | frozenset(_FUNCTIONS)
    | _words("""
    __FILE__ __LINE__ arguments break case catch classdef continue do else elseif end end_try_catch
    end_unwind_protect endclassdef endenumeration endevents endfor endfunction endif endmethods
    endparfor endproperties endswitch endwhile enumeration events for function global if methods
    otherwise parfor persistent properties return spmd switch try until unwind_protect
    unwind_protect_cleanup while i j e I J pi eps Inf NaN inf nan ans nargin nargout max sum
    isempty real_sqrt real_log remanent_rates remanent_load remanent_parameters remanent_pieces
    remanent_run ode45 odeset plot numel zeros import
    """),
    # Outside their range these two are complex in MATLAB.
    helpers=MappingProxyType(
        {
            name: f"function z = real_{name}(x)\n"
            f"  if x < 0\n    z = NaN;\n  else\n    z = {name}(x);\n  end\nend"
            for name in ("sqrt", "log")
        }
    ),
    infinity="Inf",
)

_FORTRAN = Language(
    operations={
        **_ARITHMETIC,
        **{name: f"{name.upper()}({{}})" for name in _FUNCTIONS if name != "floor"},
    },
    assignment="{} = {}",
    comment="!",
    reserved_words=_OWN_WORDS
    | frozenset(_FUNCTIONS)
    | _words("""
    ndim u icp par ijac f dfdu dfdp t bcnd icnd fopt pvls stpnt func nbc u0 u1 fb dbc getp implicit
    none integer double precision intent in out inout parameter end subroutine if then else call
    return do real program module use continue stop data common save external where not abs
    """),
    exponent="D",
    has_case=False,
)

#: The languages in which equations are written.
LANGUAGES: Final[Mapping[str, Language]] = MappingProxyType(
    {
        "matlab": _MATLAB,
        "python": _PYTHON,
        "julia": _JULIA,
        "auto07p": _FORTRAN,
        "c": _C,
        "javascript": _JAVASCRIPT,
    }
)
