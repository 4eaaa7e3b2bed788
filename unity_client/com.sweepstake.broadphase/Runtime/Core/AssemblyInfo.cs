[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Sweepstake.Core.Tests")]
[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Sweepstake.Daemon.Tests")]
