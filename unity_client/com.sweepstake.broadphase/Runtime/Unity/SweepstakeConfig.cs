#nullable enable
using System;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>Whether a thread of its own measures the backends that are not active, and prepares the next one before a switch.</summary>
    public enum LaneChoice
    {
        /// <summary>While there is a spare core; never on mobile devices.</summary>
        Auto,
        Off,
        On,
    }

    /// <summary>
    /// How a <see cref="SweepstakeManager"/> searches, decides and, if at all, speaks to a daemon. A manager without a config has these
    /// defaults. It is read when the manager is enabled.
    /// </summary>
    [CreateAssetMenu(menuName = "Sweepstake/Config", fileName = "SweepstakeConfig")]
    [DocumentationPage("components.md")]
    public sealed class SweepstakeConfig : ScriptableObject
    {
        [Tooltip("Under what name evidence is kept: the game.")]
        public string project = "default";
        [Tooltip("Under what name evidence is kept: the level. Empty: the name of the manager's scene.")]
        public string sceneName = "";
        [Tooltip("The backends, their searches and the lane that measures beside them.")]
        public SearchSettings search = new SearchSettings();
        [Tooltip("AI Decides: when it decides and what it starts from.")]
        public DecisionSettings decisions = new DecisionSettings();
        [Tooltip("A daemon that decides and keeps what it learns. Off, nothing leaves the machine.")]
        public DaemonSettings daemon = new DaemonSettings();

        /// <summary>The options of a session that begins in this mode with this backend.</summary>
        /// <param name="initialBackend">"": KDTree if all may be chosen, otherwise the first of the config's.</param>
        public SessionOptions ToSessionOptions(SessionMode mode, string initialBackend) => new SessionOptions
        {
            Mode = mode,
            Arms = string.Join(",", search.backends),
            InitialArm = initialBackend,
            ThreadCount = (uint)search.threads,
            IsSorted = search.sortsPairs,
            Shadow = search.Shadow,
            BailOutNs = ToNs(decisions.bailOutSeconds),
            SettlingNs = ToNs(decisions.settlingSeconds),
        };

        public DeciderOptions ToDeciderOptions(string defaultScene, string defaultBuild) => new DeciderOptions
        {
            Project = project,
            Scene = SceneOr(defaultScene),
            MachineClass = NullIfEmpty(daemon.machineClass),
            Build = BuildOr(defaultBuild),
            Policy = NullIfEmpty(decisions.policy),
            Seed = decisions.seed,
            DecisionIntervalNs = ToNs(decisions.intervalSeconds),
            CooldownNs = ToNs(decisions.cooldownSeconds),
            FpsFloor = decisions.fpsFloor,
            PriorsData = decisions.priors == null ? null : decisions.priors.bytes,
        };

        public LinkOptions ToLinkOptions(string defaultScene, string defaultBuild) => new LinkOptions
        {
            Daemon = daemon.address,
            Project = project,
            Scene = SceneOr(defaultScene),
            Build = BuildOr(defaultBuild),
            MachineClass = NullIfEmpty(daemon.machineClass),
            Policy = NullIfEmpty(decisions.policy),
            Seed = decisions.seed,
            AllowsOperatorOrders = daemon.allowsOperatorOrders,
            BatchIntervalMs = (uint)daemon.batchIntervalMs,
            BatchFrames = (uint)daemon.batchFrames,
        };

        private string BuildOr(string otherwise) => daemon.build.Length > 0 ? daemon.build : otherwise;

        private string SceneOr(string defaultScene) => sceneName.Length > 0 ? sceneName : defaultScene.Length > 0 ? defaultScene : "default";

        private static string? NullIfEmpty(string text) => text.Length == 0 ? null : text;

        private static ulong ToNs(float seconds) => (ulong)((decimal)seconds * 1_000_000_000m);
    }

    [Serializable]
    public sealed class SearchSettings
    {
        [Tooltip("Which backends may be chosen, by name. Empty: all.")]
        [BackendName]
        public string[] backends = Array.Empty<string>();
        [Tooltip("Threads of a search. 0 or 1: the main thread alone. The pairs do not depend on it.")]
        [Range(0, 64)]
        public int threads = 0;
        [Tooltip("Pairs ascend whatever the backend, for a game in lockstep.")]
        public bool sortsPairs = false;
        [Tooltip("A thread that measures the other backends on a spare core. Auto: off on mobile devices.")]
        public LaneChoice lane = LaneChoice.Auto;

        public ShadowMode Shadow => lane switch
        {
            LaneChoice.On => ShadowMode.On,
            LaneChoice.Auto when !Application.isMobilePlatform => ShadowMode.Auto,
            _ => ShadowMode.Off,
        };
    }

    [Serializable]
    public sealed class DecisionSettings
    {
        [Tooltip("The policy by name. Empty: the default.")]
        public string policy = "";
        [Tooltip("Of all draws. The same seed and the same measurements give the same decisions.")]
        [Min(1)]
        public uint seed = 1;
        [Tooltip("Seconds from one decision to the next.")]
        [Min(0.1f)]
        public float intervalSeconds = 2;
        [Tooltip("Seconds after a switch in which no other follows.")]
        [Min(0)]
        public float cooldownSeconds = 40;
        [Tooltip("Seconds after a switch that are not learnt from; a backend is tried for twice as long. A daemon's own setting replaces it.")]
        [Min(0)]
        public float settlingSeconds = 2;
        [Tooltip("A frame that takes longer than these seconds, and that the backend is to blame for, ends the backend at once. A daemon's own setting replaces it.")]
        [Min(0.1f)]
        public float bailOutSeconds = 5;
        [Tooltip("Frames per second below which even the best backend is not good enough. The verdict is Degraded then.")]
        [Range(0, 1000)]
        public float fpsFloor = 30;
        [Tooltip("What earlier runs have learnt, as 'Export Priors' of the inspector or `sweepstake priors export` writes it, with the extension .bytes. None: it starts from nothing.")]
        public TextAsset? priors;
    }

    /// <summary>Files are of the game's own: a path that is not absolute is one below StreamingAssets.</summary>
    [Serializable]
    public sealed class DaemonSettings
    {
        [Tooltip("On, the game connects when it is enabled, and sends what the page 'What leaves the machine' lists.")]
        public bool isUsed = false;
        [Tooltip("HOST:PORT of the daemon. The default is a daemon on this machine.")]
        public string address = "127.0.0.1:7433";
        [Tooltip("TLS. A token is sent to another machine with TLS alone.")]
        public bool usesTls = false;
        [Tooltip("Authorities of the daemon's certificate, PEM. Empty: those of the system.")]
        public string caFile = "";
        [Tooltip("The game's certificate, PEM, where the daemon asks for one. Empty: none.")]
        public string certFile = "";
        [Tooltip("The private key of the certificate, PEM.")]
        public string keyFile = "";
        [Tooltip("A file with the token that the daemon may ask for. Empty: none. Players can read what a game ships.")]
        public string tokenFile = "";
        [Tooltip("The build of the game, to compare builds. Empty: the version of the player settings.")]
        public string build = "";
        [Tooltip("Class of machine whose timings are comparable, such as 'desktop'. Empty: processor, threads, instruction set and memory.")]
        public string machineClass = "";
        [Tooltip("Operators of the daemon may choose mode and backend. Not in a game that players get.")]
        public bool allowsOperatorOrders = false;
        [Tooltip("A batch is sent after so many milliseconds.")]
        [Range(1, 10_000)]
        public int batchIntervalMs = 250;
        [Tooltip("A batch is sent after so many frames.")]
        [Range(1, 240)]
        public int batchFrames = 240;
    }
}
