#nullable enable
using System.Collections.Generic;
using System.Globalization;
using System.Text;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Plays one scenario with each backend in Manual, then with AI Decides, for the same time and with the same seed. It logs the mean detection
    /// time of each. Switch vSync off; otherwise all have the frame rate of the screen.
    /// </summary>
    [RequireComponent(typeof(ScenarioPlayer))]
    public sealed class ManualVsAI : MonoBehaviour
    {
        [SerializeField]
        [Range(2, 600)]
        [Tooltip("Duration of each run in seconds.")]
        private float secondsEach = 20;
        [SerializeField]
        [Tooltip("Skips BruteForce, which is very slow with many objects.")]
        private bool skipsBruteForce = true;

        private readonly List<string> turns = new List<string>();
        private readonly StringBuilder table = new StringBuilder("backend, frames, mean detection ms, mean frame ms\n");
        private SweepstakeManager? manager;
        private ScenarioPlayer? player;
        private int turn = -1;
        private float beganSeconds;
        private ulong firstFrame;
        private double detectionNs;
        private double frameNs;
        private ulong frames;

        /// <summary>The results so far, as CSV.</summary>
        public string Table => table.ToString();
        /// <summary>Whether all runs are complete.</summary>
        public bool IsOver => turns.Count > 0 && turn == turns.Count;

        private void Start()
        {
            manager = GetComponent<SweepstakeManager>();
            player = GetComponent<ScenarioPlayer>();
        }

        private void Update()
        {
            if (manager!.Session == null || IsOver)
                return;
            if (turn < 0)
                Begin();
            else
                Measure(manager.LastSample);
        }

        private void Begin()
        {
            foreach (string backend in manager!.Backends)
            {
                if (backend != "BruteForce" || !skipsBruteForce)
                    turns.Add(backend);
            }
            turns.Add("");
            TakeTurn(0);
        }

        private void TakeTurn(int next)
        {
            turn = next;
            if (IsOver)
            {
                Debug.Log(Table, this);
                return;
            }
            manager!.Mode = turns[turn].Length > 0 ? SessionMode.Manual : SessionMode.Ai;
            if (turns[turn].Length > 0)
                manager.SelectBackend(turns[turn]);
            player!.Restart();
            beganSeconds = Time.realtimeSinceStartup;
            firstFrame = manager.LastSample.FrameIndex + 1;
            detectionNs = frameNs = frames = 0;
        }

        private void Measure(in FrameSample sample)
        {
            if (sample.FrameIndex >= firstFrame && sample.DetectionTimeNs > 0)
            {
                detectionNs += sample.DetectionTimeNs;
                frameNs += sample.FrameTimeNs;
                ++frames;
            }
            if (Time.realtimeSinceStartup - beganSeconds < secondsEach)
                return;
            string name = turns[turn].Length > 0 ? turns[turn] : "AI Decides";
            table.AppendFormat(CultureInfo.InvariantCulture, "{0}, {1}, {2:F4}, {3:F4}\n", name, frames, Mean(detectionNs), Mean(frameNs));
            TakeTurn(turn + 1);
        }

        private double Mean(double sumNs) => frames > 0 ? sumNs / frames / 1e6 : 0;
    }
}
