// Restores what names/begin.h has hidden. Included at the end of a header, without a guard.
#pragma pop_macro("Status")
