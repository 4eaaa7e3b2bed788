// Hides macros of other libraries that use a name of these headers, until names/end.h. X11/Xlib.h,
// for example, defines Status as int. Included after a header's other includes, without a guard.
//
// The order in which the two libraries are included then does not matter. In a file that includes
// both, the name itself remains X11's: write `auto status = ...`, or #undef Status after including
// X11.
#pragma push_macro("Status")
#undef Status
