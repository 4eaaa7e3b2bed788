using System;

namespace Unity.Profiling
{
    public enum ProfilerMarkerDataUnit : byte
    {
        Undefined,
        TimeNanoseconds,
        Bytes,
        Count,
    }

    public readonly struct ProfilerCategory
    {
        public static ProfilerCategory Scripts => default;
    }

    public struct ProfilerMarker
    {
        public ProfilerMarker(string name)
        {
        }

        public AutoScope Auto() => default;

        public struct AutoScope : IDisposable
        {
            public void Dispose()
            {
            }
        }
    }
}
