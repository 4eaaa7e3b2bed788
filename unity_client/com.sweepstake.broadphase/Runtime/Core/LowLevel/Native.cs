#nullable enable
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>Checks results and reads texts of the C ABI.</summary>
    internal static unsafe class Native
    {
        internal static void Check(ResultCode result)
        {
            if (result != ResultCode.Ok)
                throw new SweepstakeException(result, Text(NativeMethods.swp_last_error()));
        }

        internal static string Text(byte* text) => Marshal.PtrToStringUTF8((IntPtr)text) ?? "";

        /// <summary>Returns textOf(0) to textOf(count − 1) as a list.</summary>
        internal static IReadOnlyList<string> Texts(uint count, Func<uint, string> textOf)
        {
            var texts = new string[count];
            for (uint index = 0; index < count; ++index)
                texts[index] = textOf(index);
            return Array.AsReadOnly(texts);
        }
    }

    /// <summary>Owns the texts and pinned bytes that are passed to one native call.</summary>
    internal sealed unsafe class CallMemory : IDisposable
    {
        private readonly List<IntPtr> texts = new List<IntPtr>();
        private readonly List<GCHandle> pins = new List<GCHandle>();

        /// <summary>Converts a text to UTF-8 with a terminating 0; null stays null.</summary>
        internal byte* Text(string? text)
        {
            if (text == null)
                return null;
            IntPtr copy = Marshal.StringToCoTaskMemUTF8(text);
            texts.Add(copy);
            return (byte*)copy;
        }

        internal byte* Pin(byte[]? bytes)
        {
            if (bytes == null || bytes.Length == 0)
                return null;
            GCHandle pin = GCHandle.Alloc(bytes, GCHandleType.Pinned);
            pins.Add(pin);
            return (byte*)pin.AddrOfPinnedObject();
        }

        public void Dispose()
        {
            foreach (IntPtr text in texts)
                Marshal.FreeCoTaskMem(text);
            foreach (GCHandle pin in pins)
                pin.Free();
            texts.Clear();
            pins.Clear();
        }
    }
}
