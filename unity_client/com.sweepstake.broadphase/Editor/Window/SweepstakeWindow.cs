#nullable enable
using System.Globalization;
using System.Linq;
using System.Text;
using Sweepstake.Unity;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>Charts of the first manager, and on request the daemon's posteriors. The data stays after play mode ends.</summary>
    [DocumentationPage("window.md")]
    internal sealed class SweepstakeWindow : EditorWindow
    {
        [SerializeField] private LiveHistory history = new LiveHistory();

        private readonly PosteriorWatcher watcher = new PosteriorWatcher();
        private readonly StringBuilder text = new StringBuilder();
        // These elements are created in CreateGUI, because Unity allows little in the constructor of a window.
        private StatusChip chip = null!;
        private Label status = null!;
        private Label posteriors = null!;
        private Button watch = null!;
        private LineChart fps = null!;
        private LineChart detection = null!;
        private LineChart pairs = null!;
        private LineChart roundTrip = null!;
        private BackendChart backend = null!;
        private int lastFrame;
        private float lastSeconds;
        private bool wasPlaying;

        [MenuItem(PackagePaths.MenuRoot + "Live Window", priority = 1)]
        internal static void Open()
        {
            SweepstakeWindow window = GetWindow<SweepstakeWindow>();
            window.titleContent = new GUIContent("Sweepstake");
            window.minSize = new Vector2(320, 240);
        }

        private void CreateGUI()
        {
            var scroll = new ScrollView();
            PackagePaths.AddStyle(scroll);
            rootVisualElement.Add(scroll);
            chip = new StatusChip();
            status = TextLabel();
            fps = new LineChart("Frame rate", "frames/s");
            detection = new LineChart("Detection", "ms");
            pairs = new LineChart("Pairs", "pairs");
            backend = new BackendChart();
            roundTrip = new LineChart("Round trip to the daemon", "ms");
            watch = new Button(ToggleWatch) { tooltip = "Reads the posteriors from the daemon of the project's config, and sends that daemon the name of the project." };
            posteriors = TextLabel();
            foreach (VisualElement part in new VisualElement[] { chip, status, fps, detection, pairs, backend, watch, posteriors, roundTrip })
                scroll.Add(part);
            Show();
            scroll.schedule.Execute(Tick).Every(1000 / LiveHistory.RateHz);
        }

        private void OnDisable() => watcher.Dispose();

        private void Tick()
        {
            if (Application.isPlaying && !wasPlaying)
                history = new LiveHistory();
            wasPlaying = Application.isPlaying;
            SweepstakeManager? manager = Shown();
            if (manager != null && !EditorApplication.isPaused)
                history.Add(FramesPerSecond(), manager.LastSample, watcher.Latest.RoundTripMs, manager.Backends.ToArray());
            ShowStatus(manager);
            Show();
        }

        private static SweepstakeManager? Shown() =>
            Application.isPlaying && SweepstakeManager.Enabled.Count > 0 ? SweepstakeManager.Enabled[0] : null;

        private float FramesPerSecond()
        {
            float seconds = Time.realtimeSinceStartup;
            float rate = seconds > lastSeconds && Time.frameCount >= lastFrame ? (Time.frameCount - lastFrame) / (seconds - lastSeconds) : float.NaN;
            lastFrame = Time.frameCount;
            lastSeconds = seconds;
            return rate;
        }

        private void ShowStatus(SweepstakeManager? manager)
        {
            chip.Show(manager == null ? SweepstakeState.Stopped : manager.State);
            text.Clear();
            if (manager == null)
                text.Append("Enter play mode in a scene with a Sweepstake Manager.");
            else
                StatusText.Append(text, manager, history.Fps.Count > 0 ? history.Fps[history.Fps.Count - 1] : 0);
            status.text = text.ToString();
        }

        private void Show()
        {
            fps.Show(history.Fps);
            detection.Show(history.DetectionMs);
            pairs.Show(history.Pairs);
            backend.Name(history.Backends);
            backend.Show(history.Backend);
            roundTrip.Show(history.RoundTripMs);
            watch.text = watcher.IsRunning ? "Stop Watching" : "Watch Posteriors";
            posteriors.text = TextOf(watcher.Latest);
        }

        private void ToggleWatch()
        {
            if (watcher.IsRunning)
            {
                watcher.Dispose();
                return;
            }
            SweepstakeConfig config = SweepstakeProjectSettings.instance.ConfigOrDefault();
            watcher.Start(config.daemon, config.project);
        }

        internal static string TextOf(PosteriorSnapshot snapshot)
        {
            var lines = new StringBuilder(snapshot.Problem);
            string scene = "";
            foreach (PosteriorLine line in snapshot.Lines)
            {
                string heading = line.MachineClass.Length > 0 ? $"{line.Scene} ({line.MachineClass})" : line.Scene;
                if (heading != scene)
                    lines.Append(lines.Length > 0 ? "\n" : "").Append(scene = heading);
                lines.AppendFormat(
                    CultureInfo.InvariantCulture, "\n    {0}: reward {1:F3} ± {2:F3}, {3} windows", line.Backend, line.Mean, line.Deviation, line.Windows);
            }
            return lines.ToString();
        }

        private static Label TextLabel()
        {
            var label = new Label();
            label.AddToClassList("sweepstake-text");
            return label;
        }
    }
}
