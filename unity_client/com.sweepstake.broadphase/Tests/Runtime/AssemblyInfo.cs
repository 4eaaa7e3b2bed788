using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Sweepstake.Components.Tests")]
