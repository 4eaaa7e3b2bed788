#nullable enable
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Text;
using Sweepstake.Unity;
using UnityEngine;
#if SWEEPSTAKE_INPUT_SYSTEM && ENABLE_INPUT_SYSTEM
using UnityEngine.InputSystem;
#endif

namespace Sweepstake.Samples
{
    /// <summary>
    /// A studio's daemon: the levels of one project connect to the same daemon, which decides for each level and stores what it learns. Shows the
    /// state of each level, the daemon's verdict, and its latest command with the reason. Keys: O opens the dashboard, C copies the start command.
    /// </summary>
    public sealed class Fleet : MonoBehaviour
    {
        /// <summary>Starts a daemon with a dashboard for this sample, in a shell on Linux.</summary>
        public const string StartCommand = "sweepstaked --data sweepstake-data --listen 127.0.0.1:7433 --http 127.0.0.1:7434";

        private const float Margin = 8;
        private const float RefreshSeconds = 0.25f;
        private const string Help =
            "No level is connected to the daemon at {0}. The game plays on. To connect:\n" +
            "1. Window > Sweepstake > Setup: install gRPC's libraries and HTTP/2, then Set Define.\n" +
            "2. Start a daemon on this machine, in a shell on Linux, or in WSL on Windows:\n" +
            "    " + StartCommand + "\n" +
            "3. The levels connect by themselves. Documentation~/daemon.md describes each step, TLS and tokens.";

        [SerializeField]
        [Tooltip("HOST:PORT of the daemon.")]
        private string address = "127.0.0.1:7433";
        [SerializeField]
        [Tooltip("Address of the daemon's dashboard.")]
        private string dashboard = "http://127.0.0.1:7434";
        [SerializeField]
        [Tooltip("Project under which the daemon stores what it learns.")]
        private string project = "fleet";
        [SerializeField]
        [Tooltip("Names of the levels. Each plays another scenario of the library.")]
        private string[] levels = { "forest", "harbour", "arena" };
        [SerializeField]
        [Range(1, 20_000)]
        [Tooltip("Number of boxes in each level.")]
        private int objectCount = 2000;
        [SerializeField]
        [Range(8, 48)]
        [Tooltip("Size of the font, in points of the screen.")]
        private int fontSize = 14;

        private readonly List<SweepstakeManager> managers = new List<SweepstakeManager>();
        private readonly List<SweepstakeConfig> configs = new List<SweepstakeConfig>();
        private readonly List<FleetLevel> sources = new List<FleetLevel>();
        private readonly StringBuilder text = new StringBuilder(2048);
        private GUIStyle? area;
        private GUIStyle? button;
        private GUIStyle? label;
        private float sinceSeconds;

        /// <summary>The managers of the levels.</summary>
        public IReadOnlyList<SweepstakeManager> Managers => managers;
        /// <summary>The displayed text.</summary>
        public string Text { get; private set; } = "";

        private void Start()
        {
            for (int index = 0; index < levels.Length; ++index)
                AddLevel(levels[index], index);
        }

        private void OnDestroy()
        {
            foreach (SweepstakeManager manager in managers)
            {
                if (manager == null)
                    continue;
                // An inactive manager does not search boxes again before it is destroyed.
                manager.gameObject.SetActive(false);
                Destroy(manager.gameObject);
            }
            foreach (SweepstakeConfig config in configs)
                Destroy(config);
            foreach (FleetLevel source in sources)
                source.Dispose();
        }

        private void AddLevel(string level, int index)
        {
            var made = new GameObject(level);
            // An inactive object gives its manager time to receive its config.
            made.SetActive(false);
            made.transform.SetParent(transform, false);
            var manager = made.AddComponent<SweepstakeManager>();
            var source = new FleetLevel(index, objectCount);
            manager.Config = ConfigOf(level);
            manager.Source = source;
            managers.Add(manager);
            sources.Add(source);
            made.SetActive(true);
        }

        private SweepstakeConfig ConfigOf(string level)
        {
            var config = ScriptableObject.CreateInstance<SweepstakeConfig>();
            config.project = project;
            config.sceneName = level;
            config.daemon.isUsed = true;
            config.daemon.address = address;
            // Lets the dashboard choose mode and backend. A game that is shipped to players leaves it off.
            config.daemon.allowsOperatorOrders = true;
            configs.Add(config);
            return config;
        }

        private void Update()
        {
            if (IsPressed('O'))
                OpenDashboard();
            if (IsPressed('C'))
                CopyCommand();
            sinceSeconds += Time.unscaledDeltaTime;
            if (sinceSeconds < RefreshSeconds)
                return;
            sinceSeconds = 0;
            Refresh();
        }

        private void OnGUI()
        {
            area ??= new GUIStyle(GUI.skin.box);
            button ??= new GUIStyle(GUI.skin.button) { fontSize = fontSize };
            label ??= new GUIStyle(GUI.skin.label) { fontSize = fontSize, wordWrap = true };
            GUILayout.BeginArea(new Rect(Margin, Margin, Screen.width - 2 * Margin, Screen.height - 2 * Margin), area);
            GUILayout.BeginHorizontal();
            if (GUILayout.Button("[O] Open the dashboard", button))
                OpenDashboard();
            if (GUILayout.Button("[C] Copy the start command", button))
                CopyCommand();
            GUILayout.EndHorizontal();
#if !ENABLE_LEGACY_INPUT_MANAGER
            GUILayout.Label("The buttons do not react to the mouse with the Input System package alone. Press the keys in brackets.", label);
#endif
            GUILayout.Label(Text, label);
            GUILayout.EndArea();
        }

        private void OpenDashboard() => Application.OpenURL(dashboard);

        private static void CopyCommand() => GUIUtility.systemCopyBuffer = StartCommand;

        private void Refresh()
        {
            text.Clear();
            managers.RemoveAll(manager => manager == null);
            foreach (SweepstakeManager manager in managers)
                Append(manager);
            if (!managers.Exists(manager => manager.State == SweepstakeState.Online || manager.State == SweepstakeState.Connecting))
                text.AppendFormat(CultureInfo.InvariantCulture, Help, address);
            Text = text.ToString();
        }

        private void Append(SweepstakeManager manager)
        {
            FrameSample sample = manager.LastSample;
            text.Append(manager.gameObject.name).Append(": ").Append(StatusText.Chip(manager.State)).AppendFormat(
                CultureInfo.InvariantCulture, ", {0}, {1:F3} ms, {2} pairs\n", manager.ActiveBackend, sample.DetectionTimeNs / 1e6, sample.PairCount);
            Verdict verdict = manager.Verdict;
            text.Append("Verdict: ").Append(verdict.Kind);
            if (verdict.LeaderProbability > 0 && verdict.LeaderArm < manager.Backends.Count)
                text.AppendFormat(CultureInfo.InvariantCulture, ", {0} is the best with {1:P0}", manager.Backends[(int)verdict.LeaderArm], verdict.LeaderProbability);
            text.Append(". ").Append(Advice.Of(verdict.Kind)).Append('\n');
            // A daemon sends only the decisions that command a switch.
            if (manager.State == SweepstakeState.Online && manager.LastDecision.Outcome == DecisionOutcome.None)
                text.Append("Decision: the daemon has commanded no switch");
            else
                StatusText.AppendDecision(text, manager);
            text.Append('\n');
            if (manager.Problem.Length > 0)
                text.Append(manager.Problem).Append('\n');
            text.Append('\n');
        }

#if SWEEPSTAKE_INPUT_SYSTEM && ENABLE_INPUT_SYSTEM
        private static bool IsPressed(char letter) => Keyboard.current != null && Keyboard.current[Key.A + (letter - 'A')].wasPressedThisFrame;
#else
        /// <summary>Unity's codes of letters are those of their small ASCII characters.</summary>
        private static bool IsPressed(char letter) => Input.GetKeyDown((KeyCode)char.ToLowerInvariant(letter));
#endif
    }
}
