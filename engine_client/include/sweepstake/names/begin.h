// Sets aside the macros of other libraries that bear a name of these headers, until names/end.h:
// X11/Xlib.h makes Status an int. Included behind a header's other includes, without a guard.
//
// Which of the two is included first does not matter then. In a file that has both, the name itself
// still is X11's: write `auto status = ...`, or #undef Status behind the include of X11.
#pragma push_macro("Status")
#undef Status
