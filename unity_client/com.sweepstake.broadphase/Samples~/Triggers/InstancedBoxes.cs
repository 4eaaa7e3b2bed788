#nullable enable
using System;
using UnityEngine;
using UnityEngine.Rendering;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Draws many boxes by GPU instancing; boxes that touch another one have a second colour. The material is a copy of a new cube's material,
    /// so that it fits every render pipeline. After its arrays have grown, nothing allocates.
    /// </summary>
    internal sealed class InstancedBoxes : IDisposable
    {
        private const int BatchSize = 500;
        private static readonly Color Resting = new Color(0.55f, 0.6f, 0.66f);
        private static readonly Color Touching = new Color(0.95f, 0.5f, 0.15f);

        private readonly Mesh mesh;
        private readonly Material resting;
        private readonly Material touching;
        private bool[] touches = Array.Empty<bool>();
        // Boxes that touch nothing fill the array from the front, boxes that touch another one from the back.
        private Matrix4x4[] places = Array.Empty<Matrix4x4>();

        internal InstancedBoxes()
        {
            GameObject cube = GameObject.CreatePrimitive(PrimitiveType.Cube);
            mesh = cube.GetComponent<MeshFilter>().sharedMesh;
            Material ofPipeline = cube.GetComponent<MeshRenderer>().sharedMaterial;
            resting = Copy(ofPipeline, Resting);
            touching = Copy(ofPipeline, Touching);
            // Naming the component type here also keeps code stripping from removing the type.
            cube.GetComponent<BoxCollider>().enabled = false;
            cube.SetActive(false);
            UnityEngine.Object.Destroy(cube);
        }

        internal void Draw(ReadOnlySpan<Aabb> boxes, ReadOnlySpan<OverlapPair> pairs)
        {
            if (touches.Length < boxes.Length)
            {
                touches = new bool[boxes.Length];
                places = new Matrix4x4[boxes.Length];
            }
            Array.Clear(touches, 0, touches.Length);
            foreach (OverlapPair pair in pairs)
                touches[pair.A] = touches[pair.B] = true;
            int front = 0;
            int back = places.Length;
            for (int index = 0; index < boxes.Length; ++index)
                places[touches[index] ? --back : front++] = PlaceOf(boxes[index]);
            Draw(resting, 0, front);
            Draw(touching, back, places.Length);
        }

        public void Dispose()
        {
            UnityEngine.Object.Destroy(resting);
            UnityEngine.Object.Destroy(touching);
        }

        private void Draw(Material material, int begin, int end)
        {
            var parameters = new RenderParams(material) { shadowCastingMode = ShadowCastingMode.Off };
            for (int start = begin; start < end; start += BatchSize)
                Graphics.RenderMeshInstanced(parameters, mesh, 0, places, Math.Min(BatchSize, end - start), start);
        }

        /// <summary>The transform that maps the unit cube to a box.</summary>
        private static Matrix4x4 PlaceOf(in Aabb box) => new Matrix4x4
        {
            m00 = box.MaxX - box.MinX, m11 = box.MaxY - box.MinY, m22 = box.MaxZ - box.MinZ, m33 = 1,
            m03 = 0.5f * (box.MinX + box.MaxX), m13 = 0.5f * (box.MinY + box.MaxY), m23 = 0.5f * (box.MinZ + box.MaxZ),
        };

        private static Material Copy(Material material, Color color)
        {
            var copy = new Material(material) { enableInstancing = true, hideFlags = HideFlags.HideAndDontSave };
            // The colour is named _Color in the Built-in pipeline, and _BaseColor in URP and HDRP.
            copy.SetColor("_Color", color);
            copy.SetColor("_BaseColor", color);
            return copy;
        }
    }
}
