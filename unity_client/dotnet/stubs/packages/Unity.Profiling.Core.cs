namespace Unity.Profiling
{
    public enum ProfilerCounterOptions : ushort
    {
        None,
        FlushOnEndOfFrame = 2,
    }

    public readonly struct ProfilerCounterValue<T>
        where T : unmanaged
    {
        public ProfilerCounterValue(ProfilerCategory category, string name, ProfilerMarkerDataUnit dataUnit, ProfilerCounterOptions counterOptions)
        {
        }

        public T Value
        {
            get => default;
            set
            {
            }
        }
    }
}
