// Hides macros of other libraries whose names these headers use, until names/end.h restores them.
// X11/Xlib.h, for example, defines Status as int. This file is included after a header's other
// includes. It has no include guard.
//
// So X11 may be included before or after these headers. In a file that includes both, `Status`
// itself remains X11's macro. Write `auto status = ...` there, or #undef Status after including
// X11.
#pragma push_macro("Status")
#undef Status
