#nullable enable
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Text;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// The plug-in of the paper in one scene. Its four modules are: Presentation, which is this component with its <see cref="Panel"/>;
    /// Simulation Core, which is the <see cref="ScenarioPlayer"/> and the manager; Algorithm Library, which is the native library behind
    /// <see cref="BroadPhaseSession"/>; Decision Engine, which is the manager's <see cref="EmbeddedDecider"/> or a daemon.
    /// </summary>
    [RequireComponent(typeof(ScenarioPlayer))]
    public sealed class Triggers : MonoBehaviour
    {
        private const int ScenarioCount = 5;
        private const float RefreshSeconds = 0.25f;

        [SerializeField]
        [Range(0.1f, 600)]
        [Tooltip("Seconds of each run of a comparison.")]
        private float secondsEach = 20;
        [SerializeField]
        [Range(8, 48)]
        [Tooltip("Size of the font, in points of the screen.")]
        private int fontSize = 14;

        private readonly StringBuilder text = new StringBuilder(1024);
        private SweepstakeManager? manager;
        private ScenarioPlayer? player;
        private Panel? panel;
        private Comparison? comparison;
        private string note = "";
        private bool isSaving;
        private float sinceSeconds;
        private int frames;

        /// <summary>Path of the CSV file with a row per frame.</summary>
        public static string FramesPath => Path.Combine(Application.persistentDataPath, "triggers-frames.csv");
        /// <summary>Path of the CSV file with the result of the latest comparison.</summary>
        public static string ComparisonPath => Path.Combine(Application.persistentDataPath, "triggers-comparison.csv");

        private void OnEnable()
        {
            manager = GetComponent<SweepstakeManager>();
            player = GetComponent<ScenarioPlayer>();
            panel = new Panel(fontSize);
            if (SweepstakeLibrary.FindProblem() == null)
                AddCommands(panel, manager, player);
        }

        private void AddCommands(Panel shown, SweepstakeManager played, ScenarioPlayer moved)
        {
            shown.AddRow(SweepstakeLibrary.Scenes.Take(ScenarioCount).Select((name, index) => new PanelCommand(
                (char)('1' + index), () => name, () => Restart(() => moved.Scenario = name), () => moved.Scenario == name)));
            shown.AddRow(new[]
            {
                new PanelCommand('H', () => "Half as many boxes", () => Restart(() => moved.ObjectCount = Math.Max(moved.ObjectCount / 2, 1))),
                new PanelCommand('D', () => "Double", () => Restart(() => moved.ObjectCount *= 2)),
            });
            shown.AddRow(SweepstakeLibrary.Backends.Select(name => new PanelCommand(
                PanelCommand.NoKey, () => name, () => Select(name), () => played.ActiveBackend == name)));
            shown.AddRow(new[]
            {
                new PanelCommand('B', () => "Next algorithm", SelectNext),
                new PanelCommand('M', () => played.Mode == SessionMode.Ai ? "Mode: AI Decides" : "Mode: Manual", ToggleMode),
            });
            shown.AddRow(new[]
            {
                new PanelCommand('C', () => IsComparing ? "Stop comparing" : "Compare all algorithms", ToggleComparison),
                new PanelCommand('S', () => isSaving ? "Stop saving" : "Save frames as CSV", ToggleCsv),
            });
        }

        private void Update()
        {
            panel!.ReadKeys();
            UpdateComparison();
            sinceSeconds += Time.unscaledDeltaTime;
            ++frames;
            if (sinceSeconds < RefreshSeconds)
                return;
            panel.Text = Figures(frames / sinceSeconds);
            sinceSeconds = 0;
            frames = 0;
        }

        private void OnGUI() => panel?.Draw(comparison == null ? Array.Empty<string[]>() : comparison.Rows);

        private bool IsComparing => comparison != null && !comparison.IsOver;

        private string Figures(double fps)
        {
            text.Clear();
            StatusText.Append(text, manager!, fps);
            if (manager!.Session == null)
                return text.ToString();
            FrameSample sample = manager.LastSample;
            text.AppendFormat(
                CultureInfo.InvariantCulture, "\nFrame {0}: {1} AABB checks; verdict: {2}", sample.FrameIndex, sample.AabbCheckCount, manager.Verdict.Kind);
            if (IsComparing)
                text.Append("\nComparing: ").Append(comparison!.Progress);
            if (note.Length > 0)
                text.Append('\n').Append(note);
            return text.ToString();
        }

        /// <summary>Selects an algorithm. It changes to Manual, because in AI Decides the decider would soon replace the algorithm.</summary>
        private void Select(string backend)
        {
            StopComparison();
            // The config may leave some of the library's algorithms out.
            if (!manager!.Backends.Contains(backend))
                return;
            manager.Mode = SessionMode.Manual;
            manager.SelectBackend(backend);
        }

        /// <summary>Changes what is played. A comparison ends, because its runs must have the same boxes.</summary>
        private void Restart(Action change)
        {
            StopComparison();
            change();
        }

        private void SelectNext()
        {
            IReadOnlyList<string> backends = manager!.Backends;
            if (manager.Session != null)
                Select(backends[(manager.Session.ActiveArm + 1) % backends.Count]);
        }

        private void ToggleMode()
        {
            StopComparison();
            manager!.Mode = manager.Mode == SessionMode.Ai ? SessionMode.Manual : SessionMode.Ai;
        }

        private void ToggleComparison()
        {
            if (IsComparing)
                StopComparison();
            else if (manager!.Session != null)
                comparison = new Comparison(manager, player!, secondsEach);
        }

        private void StopComparison()
        {
            if (IsComparing)
                comparison!.Stop();
        }

        private void UpdateComparison()
        {
            if (!IsComparing)
                return;
            comparison!.Update();
            if (comparison.IsOver)
                Try(() => File.WriteAllText(ComparisonPath, comparison.Csv), "The comparison is in " + ComparisonPath);
        }

        private void ToggleCsv()
        {
            if (manager!.Session == null)
                return;
            if (isSaving)
                isSaving = !Try(manager.StopCsv, "The frames are in " + FramesPath);
            else
                isSaving = Try(() => manager.StartCsv(FramesPath, player!.Scenario, player.Seed), "Each frame is written to " + FramesPath);
        }

        /// <summary>Runs an action that writes a file, and shows its result. Returns whether the file was written.</summary>
        private bool Try(Action write, string done)
        {
            try
            {
                write();
                note = done;
                Debug.Log("Sweepstake: " + note, this);
                return true;
            }
            catch (Exception problem) when (problem is IOException || problem is UnauthorizedAccessException)
            {
                note = problem.Message;
                Debug.LogError("Sweepstake: " + note, this);
                return false;
            }
        }
    }
}
