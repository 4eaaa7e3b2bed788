#nullable enable
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Plays the current scenario with each algorithm in Manual, then with AI Decides. All runs have the same duration and the same boxes. With
    /// vSync, all have the frame rate of the screen. Afterwards it restores the mode and the algorithm.
    /// </summary>
    internal sealed class Comparison
    {
        private const string AiDecides = "AI Decides";
        // BruteForce compares each box with each other one. With more boxes a frame would take seconds.
        private const int MaxBruteForceObjects = 10_000;
        private static readonly string[] Columns = { "algorithm", "frames", "detection ms", "frame ms", "checks", "pairs" };

        private readonly List<string> turns = new List<string>();
        private readonly List<string[]> rows = new List<string[]> { Columns };
        private readonly SweepstakeManager manager;
        private readonly ScenarioPlayer player;
        private readonly float secondsEach;
        private readonly SessionMode formerMode;
        private readonly string formerBackend;
        private int turn;
        private float beganSeconds;
        private ulong firstFrame;
        private ulong frames;
        private double detectionNs;
        private double frameNs;
        private double checks;
        private double pairs;

        /// <param name="manager">Must be running.</param>
        internal Comparison(SweepstakeManager manager, ScenarioPlayer player, float secondsEach)
        {
            this.manager = manager;
            this.player = player;
            this.secondsEach = secondsEach;
            formerMode = manager.Mode;
            formerBackend = manager.ActiveBackend;
            turns.AddRange(manager.Backends.Where(backend => backend != "BruteForce" || player.ObjectCount <= MaxBruteForceObjects));
            turns.Add(AiDecides);
            BeginTurn();
        }

        /// <summary>The heading and a row for each complete run; the values are means per frame.</summary>
        internal IReadOnlyList<string[]> Rows => rows;
        internal string Csv => string.Concat(rows.Select(row => string.Join(",", row) + "\r\n"));
        internal bool IsOver => turn == turns.Count;
        internal string Progress => IsOver ? "" : $"{turns[turn]}, run {turn + 1} of {turns.Count}";

        /// <summary>Call it once a frame. It measures the latest frame, and starts the next run if the current one is complete.</summary>
        internal void Update()
        {
            if (IsOver || manager.Session == null)
                return;
            Measure(manager.LastSample);
            if (Time.realtimeSinceStartup - beganSeconds < secondsEach)
                return;
            rows.Add(new[] { turns[turn], frames.ToString(CultureInfo.InvariantCulture), Mean(detectionNs / 1e6, "F4"), Mean(frameNs / 1e6, "F4"), Mean(checks, "F0"), Mean(pairs, "F0") });
            ++turn;
            if (IsOver)
                Restore();
            else
                BeginTurn();
        }

        internal void Stop()
        {
            turn = turns.Count;
            Restore();
        }

        private void BeginTurn()
        {
            manager.Mode = turns[turn] == AiDecides ? SessionMode.Ai : SessionMode.Manual;
            if (turns[turn] != AiDecides)
                manager.SelectBackend(turns[turn]);
            player.Restart();
            beganSeconds = Time.realtimeSinceStartup;
            firstFrame = manager.LastSample.FrameIndex + 1;
            frames = 0;
            detectionNs = frameNs = checks = pairs = 0;
        }

        private void Measure(in FrameSample sample)
        {
            if (sample.FrameIndex < firstFrame || sample.DetectionTimeNs == 0)
                return;
            ++frames;
            detectionNs += sample.DetectionTimeNs;
            frameNs += sample.FrameTimeNs;
            checks += sample.AabbCheckCount;
            pairs += sample.PairCount;
        }

        private void Restore()
        {
            manager.Mode = formerMode;
            manager.SelectBackend(formerBackend);
            player.Restart();
        }

        private string Mean(double sum, string format) => (frames > 0 ? sum / frames : 0).ToString(format, CultureInfo.InvariantCulture);
    }
}
