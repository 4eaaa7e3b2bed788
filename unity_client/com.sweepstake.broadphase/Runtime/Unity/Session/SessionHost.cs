#nullable enable
using System;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>A session, with the decider or connection that decides for it. Use it on the main thread.</summary>
    internal sealed class SessionHost
    {
        private readonly SweepstakeConfig config;
        private readonly string sceneName;
        private readonly string settings;
        private readonly Action<string> report;
        private FrameCsvWriter? csv;
        private SavedPriors? saved;
        private string workProblem = "";
        private string priorsProblem = "";
        private string csvProblem = "";

        /// <param name="report">Called with a text for each problem of decider, connection or CSV file, on the calling thread.</param>
        internal SessionHost(SweepstakeConfig config, SessionMode mode, string backend, string sceneName, Action<string> report)
        {
            this.config = config;
            this.sceneName = sceneName;
            this.report = report;
            settings = SettingsOf(config, sceneName);
            Session = new BroadPhaseSession(config.ToSessionOptions(mode, backend));
        }

        internal BroadPhaseSession Session { get; }
        internal EmbeddedDecider? Decider { get; private set; }
        internal DaemonConnection? Connection { get; private set; }

        /// <summary>Ends a connection and starts the embedded decider, which continues what was saved.</summary>
        internal void DecideHere()
        {
            EndWork(SessionWork.DisposeTimeoutMs);
            DeciderOptions options = config.ToDeciderOptions(sceneName, Application.version);
            options.Saved = saved = config.OpenSavedPriors(sceneName);
            Decider = new EmbeddedDecider(Session, options);
        }

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

        /// <summary>Keeps the session for a manager that may be enabled again, and saves what was learnt. False if it cannot continue.</summary>
        internal bool Rest(ulong endNs)
        {
            if (!CanContinue)
                return false;
            EndCsv(SteadyClock.MsUntil(endNs));
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

        internal void EndFrame(ulong frameTimeNs, FrameFlags flags)
        {
            Session.EndFrame(frameTimeNs, flags);
            csv?.Write(Session.LastSample);
        }

        internal void StartCsv(string path, string scene, ulong seed)
        {
            StopCsv();
            csv = new FrameCsvWriter(path, Session, scene, seed, vSyncCount: QualitySettings.vSyncCount);
            csvProblem = "";
        }

        internal void StopCsv() => EndCsv(FrameCsvWriter.DisposeTimeoutMs);

        /// <summary>Reports new failures of other threads, and returns the most important current problem; "" if there is none.</summary>
        /// <param name="status">The status of the connection; null without one.</param>
        /// <param name="otherProblem">A problem of the caller. It is more important than problems of files.</param>
        internal string FindProblem(ConnectionStatus? status, string otherProblem)
        {
            if (csv?.Failure != null)
                EndCsv(0);
            ReportPriorsProblem();
            SessionWork? work = (SessionWork?)Connection ?? Decider;
            if (work?.Failure != null && workProblem.Length == 0)
            {
                string what = work == Decider ? "decider" : "connection to the daemon";
                workProblem = $"Decisions have stopped, because the {what} has failed: {work.Failure.Message} Disable and enable the manager to restart it.";
                report(workProblem);
            }
            string away = status == null ? "" : status.Refusal.Length > 0 ? status.Refusal : status.LastError;
            return workProblem.Length > 0 ? workProblem :
                away.Length > 0 ? away :
                otherProblem.Length > 0 ? otherProblem :
                priorsProblem.Length > 0 ? priorsProblem : csvProblem;
        }

        /// <summary>Begins to complete the CSV file, without waiting.</summary>
        internal void BeginEnd() => csv?.Stop(0);

        /// <summary>Ends the CSV file, the decider or connection, and the session. Waits until the time `endNs` at most.</summary>
        internal void End(ulong endNs)
        {
            BeginEnd();
            EndWork(SteadyClock.MsUntil(endNs));
            EndCsv(SteadyClock.MsUntil(endNs));
            Session.Dispose();
        }

        private void EndCsv(int timeoutMs)
        {
            csv?.Stop(timeoutMs);
            if (csv?.Failure is Exception problem)
                csvProblem = "The CSV file of frames is incomplete: " + problem.Message + " Start another one.";
            else if (csv?.DroppedCount > 0)
                csvProblem = $"The CSV file of frames lacks {csv.DroppedCount} frames, because writing was too slow. Use a faster disk.";
            if (csv != null && csvProblem.Length > 0)
                report(csvProblem);
            csv = null;
        }

        private void ReportPriorsProblem()
        {
            string problem = saved?.Problem ?? "";
            if (problem.Length > 0 && problem != priorsProblem)
                report(problem);
            priorsProblem = problem;
        }

        private void EndWork(int timeoutMs)
        {
            Decider?.Stop(timeoutMs);
            Decider = null;
            ReportPriorsProblem();
            saved = null;
            Connection?.Stop(timeoutMs);
            Connection = null;
            workProblem = "";
        }
    }
}
