#nullable enable
using System;
using System.Globalization;
using System.IO;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>How a manager searches, decides and connects; without a config it uses these defaults. Read when the manager is enabled.</summary>
    [CreateAssetMenu(menuName = "Sweepstake/Config", fileName = "SweepstakeConfig")]
    [DocumentationPage("components.md")]
    public sealed class SweepstakeConfig : ScriptableObject
    {
        private const int MaxSeconds = 1_000_000_000; // more than 30 years

        [Tooltip("Name of the game, under which evidence is stored.")]
        public string project = "default";
        [Tooltip("Name of the level, under which evidence is stored. Empty: the name of the manager's scene.")]
        public string sceneName = "";
        [Tooltip("The backends, the search, and the shadow lane that measures inactive backends.")]
        public SearchSettings search = new SearchSettings();
        [Tooltip("AI Decides: its intervals and the priors that it starts from.")]
        public DecisionSettings decisions = new DecisionSettings();
        [Tooltip("A daemon that decides and stores what it learns. While it is off, nothing leaves the machine.")]
        public DaemonSettings daemon = new DaemonSettings();

        /// <summary>The options of a session that starts in this mode with this backend.</summary>
        /// <param name="initialBackend">If empty: KDTree if the config allows all backends, otherwise the first backend of the
        /// config.</param>
        /// <exception cref="SweepstakeException">A duration is not a number from 0 to 1,000,000,000 seconds.</exception>
        public SessionOptions ToSessionOptions(SessionMode mode, string initialBackend) => new SessionOptions
        {
            Mode = mode,
            Arms = string.Join(",", search.backends),
            InitialArm = initialBackend,
            ThreadCount = (uint)search.threads,
            IsSorted = search.sortsPairs,
            Shadow = search.lane == ShadowMode.Auto && Application.isMobilePlatform ? ShadowMode.Off : search.lane,
            BailOutNs = ToNs(decisions.bailOutSeconds, "Bail Out Seconds"),
            SettlingNs = ToNs(decisions.settlingSeconds, "Settling Seconds"),
        };

        public DeciderOptions ToDeciderOptions(string defaultScene, string defaultBuild) => new DeciderOptions
        {
            Project = project,
            Scene = SceneOr(defaultScene),
            MachineClass = NullIfEmpty(daemon.machineClass),
            Build = BuildOr(defaultBuild),
            Policy = NullIfEmpty(decisions.policy),
            Seed = decisions.seed,
            DecisionIntervalNs = ToNs(decisions.intervalSeconds, "Interval Seconds"),
            CooldownNs = ToNs(decisions.cooldownSeconds, "Cooldown Seconds"),
            Weights = decisions.weights.ToWeights(),
            FpsFloor = decisions.fpsFloor,
            PriorsData = decisions.priors == null ? null : decisions.priors.bytes,
        };

        /// <summary>The file with what the game has learnt about the scene on this device; null if nothing is saved.</summary>
        internal SavedPriors? OpenSavedPriors(string defaultScene)
        {
            if (!decisions.savesPriors || Application.persistentDataPath.Length == 0)
                return null;
            string device = daemon.machineClass.Length > 0 ? daemon.machineClass : $"{SystemInfo.deviceModel}, {SystemInfo.processorType}, {SystemInfo.processorCount}";
            return SavedPriors.Open(Path.Combine(Application.persistentDataPath, "Sweepstake"), project, SceneOr(defaultScene), device);
        }

        public LinkOptions ToLinkOptions(string defaultScene, string defaultBuild) => new LinkOptions
        {
            Daemon = daemon.address,
            Project = project,
            Scene = SceneOr(defaultScene),
            Build = BuildOr(defaultBuild),
            MachineClass = NullIfEmpty(daemon.machineClass),
            Policy = NullIfEmpty(decisions.policy),
            Seed = decisions.seed,
            DecisionIntervalNs = RuleOf(decisions.intervalSeconds, "Interval Seconds"),
            CooldownNs = RuleOf(decisions.cooldownSeconds, "Cooldown Seconds"),
            SettlingNs = RuleOf(decisions.settlingSeconds, "Settling Seconds"),
            Weights = daemon.usesRulesOfGame ? decisions.weights.ToWeights() : (RewardWeights?)null,
            AllowsOperatorOrders = daemon.allowsOperatorOrders,
            BatchIntervalMs = (uint)daemon.batchIntervalMs,
            BatchFrames = (uint)daemon.batchFrames,
        };

        private ulong? RuleOf(float seconds, string setting) => daemon.usesRulesOfGame ? ToNs(seconds, setting) : (ulong?)null;

        private string BuildOr(string otherwise) => daemon.build.Length > 0 ? daemon.build : otherwise;

        private string SceneOr(string defaultScene) => sceneName.Length > 0 ? sceneName : defaultScene.Length > 0 ? defaultScene : "default";

        private static string? NullIfEmpty(string text) => text.Length == 0 ? null : text;

        private static ulong ToNs(float seconds, string setting)
        {
            if (seconds >= 0 && seconds <= MaxSeconds)
                return (ulong)((decimal)seconds * 1_000_000_000m);
            throw new SweepstakeException(
                ResultCode.InvalidArgument,
                $"'{setting}' of the config is {seconds.ToString(CultureInfo.InvariantCulture)}. Set a number of seconds from 0 to {MaxSeconds}.");
        }
    }

    [Serializable]
    public sealed class SearchSettings
    {
        [Tooltip("Names of the backends that may be selected. Empty: all.")]
        [BackendName]
        public string[] backends = Array.Empty<string>();
        [Tooltip("Number of threads that search. 0 or 1: only the main thread. The pairs do not depend on this number.")]
        [Range(0, 64)] public int threads = 0;
        [Tooltip("Sorts the pairs, so that all backends give the same order, for lockstep games.")]
        public bool sortsPairs = false;
        [Tooltip("The shadow lane: a thread that measures the inactive backends on a spare core. Auto: off on mobile devices.")]
        public ShadowMode lane = ShadowMode.Auto;
    }

    [Serializable]
    public sealed class DecisionSettings
    {
        [Tooltip("Name of the policy. Empty: the default, 'adaptive'. 'paper' is Thompson sampling as in the paper.")]
        public string policy = "";
        [Tooltip("Seed of the exploration and of the random draws, which only the policy 'paper' makes.")]
        [Min(1)] public uint seed = 1;
        [Tooltip("Seconds between decisions. The default policy decides at least every second.")]
        [Min(0.1f)] public float intervalSeconds = 2;
        [Tooltip("Seconds after a switch during which the decider does not switch again. The default policy may wait less.")]
        [Min(0)] public float cooldownSeconds = 40;
        [Tooltip("Seconds after a switch that are excluded from learning. The default policy uses at most 1. A trial of a backend lasts twice as long. A daemon replaces this, unless it uses the rules of the game.")]
        [Min(0)] public float settlingSeconds = 2;
        [Tooltip("Weights of the reward of the policy 'paper'; their sum must be 1.")]
        public WeightSettings weights = new WeightSettings();
        [Tooltip("Bail-out limit in seconds: if the backend makes a frame longer than this, it is replaced at once. A daemon replaces this by its own setting.")]
        [Min(0.1f)] public float bailOutSeconds = 5;
        [Tooltip("Frame-rate floor: the verdict is Degraded if even the best backend keeps the game below this number of frames per second.")]
        [Range(0, 1000)] public float fpsFloor = 30;
        [Tooltip("What earlier runs have learnt: a file of 'Export Priors' in the inspector or of `sweepstake priors export`, with the extension .bytes. None: it starts without priors.")]
        public TextAsset? priors;
        [Tooltip("On: what the game learns about a scene is saved in Application.persistentDataPath on each device, and the next run continues from it. A daemon saves it instead while the game is connected.")]
        public bool savesPriors = true;
    }

    /// <summary>Weights of the four scores in the paper's reward. Other weights than the default start without earlier evidence.</summary>
    [Serializable]
    public sealed class WeightSettings
    {
        [Tooltip("Weight of the frame rate.")]
        public double frameRate = 0.55;
        [Tooltip("Weight of the detection time.")]
        public double detection = 0.25;
        [Tooltip("Weight of the memory.")]
        public double memory = 0.12;
        [Tooltip("Weight of the AABB checks.")]
        public double checks = 0.08;

        public RewardWeights ToWeights() => new RewardWeights(frameRate, detection, memory, checks);
    }

    /// <summary>Settings of the connection to a daemon. A relative path of a file is relative to StreamingAssets.</summary>
    [Serializable]
    public sealed class DaemonSettings
    {
        [Tooltip("On: the game connects when the manager is enabled, and sends what the page 'What leaves the machine' lists.")]
        public bool isUsed = false;
        [Tooltip("HOST:PORT of the daemon. The default is a daemon on this machine.")]
        public string address = "127.0.0.1:7433";
        [Tooltip("Uses TLS. A token is sent to another machine only over TLS.")]
        public bool usesTls = false;
        [Tooltip("PEM file of the certificate authorities for the daemon's certificate. Empty: those of the system.")]
        public string caFile = "";
        [Tooltip("PEM file of the game's certificate, if the daemon requires one. Empty: none.")]
        public string certFile = "";
        [Tooltip("PEM file of the certificate's private key.")]
        public string keyFile = "";
        [Tooltip("File with the token, if the daemon requires one. Empty: none. Players can read all files that a game ships.")]
        public string tokenFile = "";
        [Tooltip("Name of the game's build, to compare builds. Empty: the version of the player settings.")]
        public string build = "";
        [Tooltip("Class of machines whose timings are comparable, such as 'desktop'. Empty: processor, threads, instruction set and memory.")]
        public string machineClass = "";
        [Tooltip("On: the daemon uses interval, cooldown, settling and weights of 'Decisions' for this game. Off: those of its own configuration.")]
        public bool usesRulesOfGame = false;
        [Tooltip("Lets operators of the daemon choose mode and backend. Leave it off in a game that is shipped to players.")]
        public bool allowsOperatorOrders = false;
        [Tooltip("Milliseconds after which a batch of frames is sent.")]
        [Range(1, 10_000)] public int batchIntervalMs = 250;
        [Tooltip("Number of frames after which a batch is sent.")]
        [Range(1, 240)] public int batchFrames = 240;
    }
}
