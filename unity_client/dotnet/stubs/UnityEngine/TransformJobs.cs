using System;
using System.Collections.Generic;
using Unity.Jobs;

namespace UnityEngine.Jobs
{
    public struct TransformAccess
    {
        private readonly Transform transform;

        internal TransformAccess(Transform transform)
        {
            this.transform = transform;
        }

        public bool isValid => transform != null;
        public Matrix4x4 localToWorldMatrix => transform.localToWorldMatrix;
    }

    public struct TransformAccessArray : IDisposable
    {
        public TransformAccessArray(int capacity, int desiredJobCount = -1)
        {
            Transforms = new List<Transform>(capacity);
        }

        internal List<Transform> Transforms { get; private set; }

        public void Add(Transform transform) => Transforms.Add(transform);

        public void RemoveAtSwapBack(int index)
        {
            Transforms[index] = Transforms[Transforms.Count - 1];
            Transforms.RemoveAt(Transforms.Count - 1);
        }

        public void Dispose() => Transforms = null;
    }

    public interface IJobParallelForTransform
    {
        void Execute(int index, TransformAccess transform);
    }

    public static class IJobParallelForTransformExtensions
    {
        public static JobHandle ScheduleReadOnly<T>(this T jobData, TransformAccessArray transforms, int batchSize, JobHandle dependsOn = default)
            where T : struct, IJobParallelForTransform
        {
            for (int index = 0; index < transforms.Transforms.Count; ++index)
                jobData.Execute(index, new TransformAccess(transforms.Transforms[index]));
            return default;
        }
    }
}
