#nullable enable
using System.Collections.Generic;
using System.IO;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Records the boxes that a manager searches, frame by frame, to an .aabbs file. `sweepstake-lab trace --scene FILE` then measures every backend
    /// on this level, and `sweepstake-lab replay` every policy. It writes on the main thread, so do not use it in a shipped game.
    /// </summary>
    [RequireComponent(typeof(SweepstakeManager))]
    [DefaultExecutionOrder(10_100)]
    public sealed class LevelRecorder : MonoBehaviour
    {
        [SerializeField]
        [Tooltip("The file; a relative path is relative to the game's persistent data.")]
        private string file = "level.aabbs";
        [SerializeField]
        [Range(1, 100_000)]
        [Tooltip("Number of frames after which the recording ends.")]
        private int maxFrames = 3600;

        private readonly List<Aabb> boxes = new List<Aabb>();
        private AabbsWriter? writer;

        /// <summary>Path of the recording.</summary>
        public string FilePath => Path.Combine(Application.persistentDataPath, file);
        public bool IsRecording => writer != null;

        private void OnEnable() => writer = new AabbsWriter(FilePath, gameObject.scene.name);

        private void OnDisable() => Finish();

        private void LateUpdate()
        {
            IBroadPhaseSource? source = GetComponent<SweepstakeManager>().Source;
            if (writer == null || source == null)
                return;
            source.CopyBoxes(boxes);
            writer.Write(boxes);
            if (writer.FrameCount > maxFrames)
                Finish();
        }

        private void Finish()
        {
            if (writer == null)
                return;
            try
            {
                writer.Finish();
                Debug.Log($"Sweepstake: {writer.FrameCount} frames are in {FilePath}.", this);
            }
            catch (System.InvalidOperationException empty)
            {
                Debug.LogWarning("Sweepstake: " + empty.Message, this);
            }
            writer = null;
        }
    }
}
