using System;

namespace Unity.Burst
{
    [AttributeUsage(AttributeTargets.Struct | AttributeTargets.Class | AttributeTargets.Method)]
    public class BurstCompileAttribute : Attribute
    {
    }
}
