#nullable enable
using System;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// A session, with the decider or connection that decides for it. It is created from a config and can be changed while the game runs.
    /// Use it on the main thread.
    /// </summary>
    internal sealed class SessionHost
    {
        private readonly SweepstakeConfig config;
        private readonly string sceneName;
        private readonly string settings;
        private readonly Action<string> tell;
        private FrameCsvWriter? csv;
        private SavedPriors? saved;

        /// <param name="tell">Called with a text for each problem of decider, connection or CSV file, on the calling thread.</param>
        internal SessionHost(SweepstakeConfig config, SessionMode mode, string backend, string sceneName, Action<string> tell)
        {
            this.config = config;
            this.sceneName = sceneName;
            this.tell = tell;
            settings = SettingsOf(config, sceneName);
            Session = new BroadPhaseSession(config.ToSessionOptions(mode, backend));
        }

        internal BroadPhaseSession Session { get; }
        internal EmbeddedDecider? Decider { get; private set; }
        internal DaemonConnection? Connection { get; private set; }
        /// <summary>Why no decisions are made; "" while a decider or a connection works.</summary>
        internal string WorkProblem { get; private set; } = "";
        /// <summary>Why the latest CSV file is incomplete; "" while no row is known to be missing.</summary>
        internal string CsvProblem { get; private set; } = "";

        /// <summary>Why saved priors were not read or written; "" if nothing is wrong with them.</summary>
        internal string PriorsProblem { get; private set; } = "";

        /// <summary>Ends a connection and starts the embedded decider, which continues what was saved.</summary>
        internal void DecideHere()
        {
            EndWork(SessionWork.DisposeTimeoutMs);
            DeciderOptions options = config.ToDeciderOptions(sceneName, Application.version);
            options.Saved = saved = config.OpenSavedPriors(sceneName);
            Decider = new EmbeddedDecider(Session, options);
        }

        /// <summary>
        /// Keeps the session for a manager that may be enabled again, and begins to save what was learnt. Returns false if the session
        /// cannot continue, because a daemon decides or the decider has failed.
        /// </summary>
        internal bool Rest(ulong endNs)
        {
            if (!CanContinue)
                return false;
            EndCsv(endNs);
            Decider!.IsPaused = true;
            Decider.BeginSave();
            Session.Trim();
            return true;
        }

        /// <summary>Continues after Rest. Returns false if the settings have changed, or Shutdown has ended the session.</summary>
        internal bool Continue(SweepstakeConfig wanted, SessionMode mode, string backend, string wantedScene)
        {
            if (!CanContinue || wanted != config || SettingsOf(wanted, wantedScene) != settings)
                return false;
            Session.Mode = mode;
            if (mode == SessionMode.Manual && backend.Length > 0)
                Session.SelectArm(backend);
            Decider!.IsPaused = false;
            return true;
        }

        private bool CanContinue => Decider != null && Decider.Failure == null && !Decider.HasEnded;

        private static string SettingsOf(SweepstakeConfig config, string sceneName) => sceneName + JsonUtility.ToJson(config);

        /// <summary>Begins to save what was learnt, without waiting.</summary>
        internal void BeginSave() => Decider?.BeginSave();

        /// <summary>
        /// Ends the embedded decider and connects to a daemon. If the connection cannot be created, the embedded decider starts again.
        /// </summary>
        internal void DecideThere(ITelemetryTransport transport, LinkOptions options)
        {
            EndWork(SessionWork.DisposeTimeoutMs);
            try
            {
                Connection = new DaemonConnection(Session, transport, options);
            }
            catch (SweepstakeException)
            {
                DecideHere();
                throw;
            }
        }

        internal void EndFrame(ulong frameTimeNs, FrameFlags flags)
        {
            Session.EndFrame(frameTimeNs, flags);
            csv?.Write(Session.LastSample);
        }

        internal void StartCsv(string path, string scene, ulong seed)
        {
            StopCsv();
            csv = new FrameCsvWriter(path, Session, scene, seed, vSyncCount: QualitySettings.vSyncCount);
            CsvProblem = "";
        }

        internal void StopCsv()
        {
            csv?.Dispose();
            LeaveCsv();
        }

        /// <summary>Reports failures of other threads since the last call.</summary>
        internal void TellFailures()
        {
            if (csv?.Failure != null)
                LeaveCsv();
            TellPriorsProblem();
            SessionWork? work = (SessionWork?)Connection ?? Decider;
            if (work?.Failure == null || WorkProblem.Length > 0)
                return;
            string what = work == Decider ? "decider" : "connection to the daemon";
            WorkProblem = $"Decisions have stopped, because the {what} has failed: {work.Failure.Message} Disable and enable the manager to restart it.";
            tell(WorkProblem);
        }

        /// <summary>Begins to complete the CSV file, without waiting.</summary>
        internal void BeginEnd() => csv?.Stop(0);

        /// <summary>Ends the CSV file, the decider or connection, and the session. Waits until the time `endNs` at most.</summary>
        internal void End(ulong endNs)
        {
            BeginEnd();
            EndWork(MsUntil(endNs));
            EndCsv(endNs);
            Session.Dispose();
        }

        private void EndCsv(ulong endNs)
        {
            csv?.Stop(MsUntil(endNs));
            LeaveCsv();
        }

        /// <summary>Returns the deadline for an end that starts now.</summary>
        internal static ulong DeadlineNs() => SteadyClock.NowNs + (ulong)SessionWork.DisposeTimeoutMs * 1_000_000;

        private static int MsUntil(ulong endNs)
        {
            ulong nowNs = SteadyClock.NowNs;
            return nowNs < endNs ? (int)((endNs - nowNs) / 1_000_000) : 0;
        }

        private void LeaveCsv()
        {
            if (csv?.Failure is Exception problem)
                CsvProblem = "The CSV file of frames is incomplete: " + problem.Message + " Start another one.";
            else if (csv?.DroppedCount > 0)
                CsvProblem = $"The CSV file of frames lacks {csv.DroppedCount} frames, because writing was too slow. Use a faster disk.";
            if (csv != null && CsvProblem.Length > 0)
                tell(CsvProblem);
            csv = null;
        }

        private void TellPriorsProblem()
        {
            string problem = saved?.Problem ?? "";
            if (problem.Length > 0 && problem != PriorsProblem)
                tell(problem);
            PriorsProblem = problem;
        }

        private void EndWork(int timeoutMs)
        {
            Decider?.Stop(timeoutMs);
            Decider = null;
            TellPriorsProblem();
            saved = null;
            Connection?.Stop(timeoutMs);
            Connection = null;
            WorkProblem = "";
        }
    }
}
