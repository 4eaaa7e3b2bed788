/* Tests that a C program can load the package's shared library of the C ABI. */
#include "sweepstake/c_api.h"

int main(void) { return swp_abi_version() == SWP_ABI_VERSION ? 0 : 1; }
