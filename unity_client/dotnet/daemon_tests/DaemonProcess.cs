using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Net;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>A real sweepstaked with its own folder, which is kept over a restart.</summary>
    internal sealed class DaemonProcess : IDisposable
    {
        /// <summary>
        /// A loopback address that no other test uses, so that the port of a stopped daemon stays free for its successor.
        /// </summary>
        internal static readonly IPAddress Host = new IPAddress(
            new byte[] { 127, (byte)(1 + (Environment.ProcessId >> 16)), (byte)(Environment.ProcessId >> 8), (byte)Environment.ProcessId });

        private readonly string[] moreArguments;
        private Process process;

        internal DaemonProcess(params string[] moreArguments)
            : this(null, moreArguments)
        {
        }

        /// <param name="prepare">Runs on the data folder before the first start, for example to create a token.</param>
        internal DaemonProcess(Action<DaemonProcess> prepare, string[] moreArguments, string listen = null)
        {
            this.moreArguments = moreArguments;
            Folder = Directory.CreateTempSubdirectory("sweepstaked").FullName;
            prepare?.Invoke(this);
            Start(listen ?? Host + ":0");
        }

        internal string Folder { get; }
        internal string Address { get; private set; }
        /// <summary>Set only with --http.</summary>
        internal string HttpAddress { get; private set; }

        /// <summary>The path of a program in the build tree under test.</summary>
        internal static string Program(string name)
        {
            string build = Environment.GetEnvironmentVariable("UNITY_CLIENT_BUILD") ??
                throw new InvalidOperationException("Set UNITY_CLIENT_BUILD to the build folder, such as build/dev.");
            return Path.Combine(build, "bin", name);
        }

        internal string Run(params string[] arguments)
        {
            var all = new List<string>(arguments) { "--data", Folder };
            using Process command = Process.Start(new ProcessStartInfo(Program("sweepstaked"), all) { RedirectStandardOutput = true });
            string output = command.StandardOutput.ReadToEnd();
            command.WaitForExit();
            Assert.That(command.ExitCode, Is.EqualTo(0), string.Join(' ', all));
            return output.Trim();
        }

        internal void Kill()
        {
            process.Kill();
            process.WaitForExit();
        }

        internal void Restart() => Start(Address);

        /// <summary>Restarts the daemon with an empty data folder, so that it has learnt nothing.</summary>
        internal void BeginAnew()
        {
            Kill();
            Directory.Delete(Folder, true);
            Directory.CreateDirectory(Folder);
            Start(Address);
        }

        internal void Pause() => Signal("-STOP");

        internal void Continue() => Signal("-CONT");

        public void Dispose()
        {
            if (!process.HasExited)
                Kill();
            Directory.Delete(Folder, true);
        }

        private void Signal(string signal)
        {
            using Process kill = Process.Start("kill", new[] { signal, process.Id.ToString() });
            kill.WaitForExit();
            Assert.That(kill.ExitCode, Is.EqualTo(0));
        }

        private void Start(string listen)
        {
            string portFile = Path.Combine(Folder, "port");
            File.Delete(portFile);
            var arguments = new List<string>
            {
                "--listen", listen, "--data", Folder, "--port-file", portFile, "--max-time-scale", "1000", "--log-level", "off",
            };
            arguments.AddRange(moreArguments);
            process = Process.Start(new ProcessStartInfo(Program("sweepstaked"), arguments));
            Eventually.Is(() => File.Exists(portFile), () => "listening", () => Assert.That(process.HasExited, Is.False, "the daemon ended at once"));
            string[] ports = File.ReadAllLines(portFile);
            Address = Host + ":" + ports[0];
            HttpAddress = ports.Length > 1 ? "127.0.0.1:" + ports[1] : null;
        }
    }
}
