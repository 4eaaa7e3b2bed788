using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Sweepstake.Core.Tests")]
