"""What ParaView shows of the filters."""
