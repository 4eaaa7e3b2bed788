using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Sweepstake.Core.Tests")]
[assembly: InternalsVisibleTo("Sweepstake.Daemon.Tests")]
