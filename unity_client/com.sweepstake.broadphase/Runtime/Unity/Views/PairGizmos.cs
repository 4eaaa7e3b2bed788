#nullable enable
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>Draws the boxes of some pairs in the scene view; off by default.</summary>
    [AddComponentMenu("Sweepstake/Sweepstake Pair Gizmos")]
    [RequireComponent(typeof(SweepstakeManager))]
    [DisallowMultipleComponent]
    [DocumentationPage("components.md")]
    public sealed class PairGizmos : MonoBehaviour
    {
        [Tooltip("Draws the boxes of pairs, where gizmos are shown.")]
        [SerializeField] private bool isDrawn = false;
        [Tooltip("Largest number of pairs that are drawn; drawing costs time in the editor.")]
        [SerializeField, Range(1, 2000)] private int maxPairs = 200;
        [Tooltip("The colour of the boxes.")]
        [SerializeField] private Color color = new Color(0.95f, 0.5f, 0.15f);

        public bool IsDrawn { get => isDrawn; set => isDrawn = value; }
        /// <summary>Number of pairs that were drawn most recently.</summary>
        public int DrawnCount { get; private set; }

        private void OnDrawGizmos()
        {
            DrawnCount = 0;
            var manager = GetComponent<SweepstakeManager>();
            if (!isDrawn || !Application.isPlaying || !manager.HasSearched || !(manager.Source is IBroadPhaseSource source))
                return;
            Gizmos.color = color;
            while (DrawnCount < maxPairs && source.TryGetPair(DrawnCount, out Aabb a, out Aabb b))
            {
                Draw(a);
                Draw(b);
                ++DrawnCount;
            }
        }

        private static void Draw(in Aabb box)
        {
            var min = new Vector3(box.MinX, box.MinY, box.MinZ);
            var max = new Vector3(box.MaxX, box.MaxY, box.MaxZ);
            Gizmos.DrawWireCube(0.5f * (min + max), max - min);
        }
    }
}
