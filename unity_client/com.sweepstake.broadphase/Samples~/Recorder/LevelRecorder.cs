#nullable enable
using System.Collections.Generic;
using System.IO;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Records what a manager searches in, frame by frame, to an .aabbs file: then `sweepstake-lab trace --scene FILE` measures every backend on
    /// this very level, and `sweepstake-lab replay` every policy. It writes on the main thread: it is for recording, not for players.
    /// </summary>
    [RequireComponent(typeof(SweepstakeManager))]
    [DefaultExecutionOrder(10_100)]
    public sealed class LevelRecorder : MonoBehaviour
    {
        [SerializeField]
        [Tooltip("The file; a path that is not absolute is one below the game's persistent data.")]
        private string file = "level.aabbs";
        [SerializeField]
        [Range(1, 100_000)]
        [Tooltip("After so many frames it ends by itself.")]
        private int maxFrames = 3600;

        private readonly List<Aabb> boxes = new List<Aabb>();
        private AabbsWriter? writer;

        /// <summary>Where the recording is, or will be.</summary>
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
