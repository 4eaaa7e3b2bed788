// Restores the macros that names/begin.h has hidden. Included at the end of a header. It has no
// include guard.
#pragma pop_macro("Status")
