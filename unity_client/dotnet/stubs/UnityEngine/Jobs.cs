using System;
using System.Collections;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Unity.Jobs;

namespace Unity.Collections
{
    public enum Allocator
    {
        Persistent = 4,
    }

    public enum NativeArrayOptions
    {
        UninitializedMemory = 0,
        ClearMemory = 1,
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class ReadOnlyAttribute : Attribute
    {
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class WriteOnlyAttribute : Attribute
    {
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class NativeDisableParallelForRestrictionAttribute : Attribute
    {
    }

    public unsafe struct NativeArray<T> : IDisposable, IEnumerable<T>
        where T : struct
    {
        private T[] values;
        private GCHandle pin;

        public NativeArray(int length, Allocator allocator, NativeArrayOptions options = NativeArrayOptions.ClearMemory)
        {
            values = new T[length];
            pin = GCHandle.Alloc(values, GCHandleType.Pinned);
        }

        public int Length => values.Length;
        public T this[int index] { get => values[index]; set => values[index] = value; }
        internal void* Start => (void*)pin.AddrOfPinnedObject();

        public static void Copy(NativeArray<T> src, NativeArray<T> dst, int length) => Array.Copy(src.values, dst.values, length);

        public Span<T> AsSpan() => values;
        public ReadOnlySpan<T> AsReadOnlySpan() => values;
        public void Dispose() => pin.Free();

        IEnumerator<T> IEnumerable<T>.GetEnumerator() => ((IEnumerable<T>)values).GetEnumerator();
        IEnumerator IEnumerable.GetEnumerator() => values.GetEnumerator();
    }
}

namespace Unity.Collections.LowLevel.Unsafe
{
    [AttributeUsage(AttributeTargets.Field)]
    public sealed class NativeDisableUnsafePtrRestrictionAttribute : Attribute
    {
    }

    public static unsafe class NativeArrayUnsafeUtility
    {
        public static void* GetUnsafePtr<T>(this NativeArray<T> nativeArray)
            where T : struct => nativeArray.Start;

        public static void* GetUnsafeReadOnlyPtr<T>(this NativeArray<T> nativeArray)
            where T : struct => nativeArray.Start;
    }
}

namespace Unity.Jobs
{
    public interface IJob
    {
        void Execute();
    }

    public interface IJobParallelFor
    {
        void Execute(int index);
    }

    /// <summary>In this stub a job runs when it is scheduled.</summary>
    public struct JobHandle
    {
        public void Complete()
        {
        }
    }

    public static class IJobExtensions
    {
        public static JobHandle Schedule<T>(this T jobData, JobHandle dependsOn = default)
            where T : struct, IJob
        {
            jobData.Execute();
            return default;
        }
    }

    public static class IJobParallelForExtensions
    {
        public static JobHandle Schedule<T>(this T jobData, int arrayLength, int innerloopBatchCount, JobHandle dependsOn = default)
            where T : struct, IJobParallelFor
        {
            for (int index = 0; index < arrayLength; ++index)
                jobData.Execute(index);
            return default;
        }
    }
}
