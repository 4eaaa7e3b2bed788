// The program that owns the tests' precompiled headers does nothing.
int main() { return 0; }
