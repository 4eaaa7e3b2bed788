#nullable enable
using System.Collections.Generic;

namespace Sweepstake.LowLevel
{
    /// <summary>Collects differences between the struct layouts of this runtime, of the headers and of the loaded library.</summary>
    internal sealed class LayoutProblems
    {
        private readonly List<string> found = new List<string>();

        internal bool IsEmpty => found.Count == 0;

        /// <summary>
        /// Compares the size of a struct. If `grows` is true, the struct may be larger in the library, because newer libraries append
        /// fields.
        /// </summary>
        internal void Size(string name, uint number, int here, int inHeaders, bool grows)
        {
            uint inLibrary = NativeMethods.swp_struct_size(number);
            if (here != inHeaders || inLibrary < here || (inLibrary > here && !grows))
                found.Add($"{name} has {here} bytes in C#, {inHeaders} in the C headers and {inLibrary} in the library");
        }

        internal void Field(string name, long here, int inHeaders)
        {
            if (here != inHeaders)
                found.Add($"{name} is at offset {here} in C# and at {inHeaders} in the C headers");
        }

        public override string ToString() => string.Join("; ", found);
    }
}
