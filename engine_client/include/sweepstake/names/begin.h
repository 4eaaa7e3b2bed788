// Hides macros of other libraries whose name these headers use, until names/end.h restores them.
// X11/Xlib.h, for example, defines Status as int. This file is included after a header's other
// includes. It has no include guard.
//
// So the order in which the two libraries are included does not matter. In a file that includes
// both, `Status` itself remains X11's macro. Write `auto status = ...` there, or #undef Status
// after including X11.
#pragma push_macro("Status")
#undef Status
