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
        public ProfilerCategory(string categoryName)
        {
        }
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
