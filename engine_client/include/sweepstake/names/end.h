// Brings back what names/begin.h has set aside. At the end of a header, without a guard.
#pragma pop_macro("Status")
